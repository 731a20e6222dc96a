# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A log as a page shows it, and as a scene that needs no server: whole, in order, small."""

import base64
import html
import re
import socket
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from example_flights import log_of, orbiting

from uav_tracking_mpc import load_configuration
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.view import recorded_scene as module
from uav_tracking_mpc.view.recorded_scene import BUDGET, LoggedSource, pace_of, recorded_scene

pytest.importorskip("viser", reason="the scene needs viser")
DATA = re.compile(r'__VISER_EMBED_DATA__="([^"]*)"')


class Addresses(HTMLParser):
    """Every address that a browser would fetch by itself."""

    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attrs):
        wanted = {"src", "srcset", "href", "data", "poster"}
        self.found += [value for name, value in attrs if name in wanted and tag != "a"]


def messages(page):
    """Times in [s] and messages of a scene, and the length of the replay in [s]."""
    import msgspec
    import zstandard

    packed = base64.b64decode(DATA.search(page).group(1))
    size = int.from_bytes(packed[:8], "little")
    inner = zstandard.ZstdDecompressor().decompressobj().decompress(packed[8:])
    assert len(inner) == size
    length = int.from_bytes(inner[:8], "little")
    content = msgspec.msgpack.decode(inner[8 : 8 + length])
    return content["messages"], content["durationSeconds"]


def flight(count, step=0.5):
    tracking = load_configuration("paper").controller
    return orbiting(count, tracking.orbit, step, tracking=tracking)


@pytest.fixture(scope="module")
def scene():
    """A quarter of a minute of the paper's orbit."""
    log = flight(31)
    return log, recorded_scene(log)


def test_the_frames_are_those_of_the_flight_in_its_order(scene):
    """Every state of it, where and when it was."""
    log, replay = scene
    sent, duration = messages(replay.html)
    times = [time for time, _ in sent]
    assert times == sorted(times) and times[0] == 0.0
    assert duration == pytest.approx(15.0)
    places = {
        round(time, 6): message["position"]
        for time, message in sent
        if message["type"] == "SetPositionMessage" and message["name"].endswith("/aircraft")
    }
    assert len(places) == replay.frames == len(log.time)
    np.testing.assert_allclose(list(places), log.time, atol=1e-6)
    np.testing.assert_allclose(list(places.values()), log.vehicle[:, :3], atol=1e-6)


def test_it_asks_for_nothing(scene):
    """What it names is inside, or is a link for people."""
    _, replay = scene
    addresses = Addresses()
    addresses.feed(replay.html)
    assert addresses.found and all(value.startswith("data:") for value in addresses.found)
    assert not re.search(r"@import|url\(\s*['\"]?https?:", replay.html)


def test_it_is_small_whatever_is_drawn(scene, monkeypatch):
    """With no room for all frames there are fewer of them, from the begin to the end."""
    log, replay = scene
    whole = len(html.escape(replay.html))
    assert whole < BUDGET < 3_000_000
    with monkeypatch.context() as patch:
        patch.setattr(module, "FRAMES", 2)
        least = len(html.escape(recorded_scene(log).html))
    monkeypatch.setattr(module, "BUDGET", (least + whole) // 2)
    fewer = recorded_scene(log)
    assert len(html.escape(fewer.html)) <= module.BUDGET
    assert 2 <= fewer.frames < replay.frames
    _, duration = messages(fewer.html)
    assert duration == pytest.approx(15.0)


def test_a_long_flight_is_played_faster(monkeypatch):
    """An hour within five minutes, in so many frames."""
    monkeypatch.setattr(module, "FRAMES", 60)
    replay = recorded_scene(flight(1801, step=2.0))
    assert replay.pace == 20.0
    assert replay.frames <= module.FRAMES
    _, duration = messages(replay.html)
    assert duration == pytest.approx(180.0)


@pytest.mark.parametrize(
    ("duration", "pace"), [(1.0, 1), (300.0, 1), (301.0, 2), (1500.0, 5), (3600.0, 20), (1e5, 500)]
)
def test_paces(duration, pace):
    assert pace_of(duration) == pace


def test_nothing_is_printed_and_nobody_else_reaches_it(capfd, monkeypatch):
    """The server that viser needs is on this machine alone, and gone afterwards."""
    bound = []
    bind = socket.socket.bind

    def watched(self, address):
        bound.append(address)
        return bind(self, address)

    monkeypatch.setattr(socket.socket, "bind", watched)
    recorded_scene(flight(3))
    assert capfd.readouterr().out == ""
    assert {host for host, *_ in bound} <= {"127.0.0.1"}


def test_states_that_are_not_known_are_left_out():
    """A hole in the middle."""
    log = flight(20)
    vehicle = log.vehicle.copy()
    vehicle[5:9] = np.nan
    replay = recorded_scene(replace(log, vehicle=vehicle))
    assert replay.frames == 16
    assert "NaN" not in str(messages(replay.html))


def test_it_is_as_dark_as_the_reader_likes(scene):
    assert "prefers-color-scheme: dark" in scene[1].html


@pytest.mark.parametrize("count", [0, 1])
def test_a_record_without_a_flight_has_no_scene(count):
    tracking = load_configuration("paper").controller
    assert recorded_scene(replace(orbiting(count), tracking=tracking)) is None


def test_without_parameters_or_viser_there_is_none(monkeypatch):
    assert recorded_scene(log_of(np.tile([150.0, 1.57, 50.0, 0.0, 4.0], (9, 1)))) is None
    monkeypatch.setitem(sys.modules, "viser", None)
    assert recorded_scene(flight(9)) is None


FIRST, SECOND = Orbit(300.0, 120.0, 22.0), Orbit(400.0, 150.0, 20.0)


def test_the_orbit_that_is_wanted_changes_as_it_was_asked_for():
    log = orbiting(20, SECOND, 0.5, orbits=((1.0, FIRST), (6.0, SECOND)))
    source = LoggedSource(log, load_configuration("small_uav").controller)
    source.clock.pause()
    wanted = []
    for time in (0.0, 5.0, 7.0):
        source.clock.seek(time)
        wanted.append(source.flights()[0].sight.wanted.centre[2])
    np.testing.assert_allclose(wanted, [120.0, 120.0, 150.0])
