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

"""The slider follows the clock of a record, and leaves the hand that moves it alone."""

import asyncio
import contextlib
import io
import time

import pytest
import viser
from viser._messages import GuiUpdateMessage

from uav_tracking_mpc.view.panel import replay
from uav_tracking_mpc.view.panel.replay import Replay, clock_words
from uav_tracking_mpc.view.watched_flight import PlayClock

WAIT = 60.0  # s, for what other threads do on a loaded machine


class Source:
    """A record of two aircraft."""

    def __init__(self):
        self.wall = 0.0
        self.clock = PlayClock(-2.0, 600.0, lambda: self.wall)
        self._flights = [object(), object()]

    def flights(self):
        return self._flights


@pytest.fixture(scope="module")
def server():
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer("127.0.0.1", 18180, verbose=False)
    server._connected_clients[0] = object()  # a browser, as far as events know it
    yield server
    server._connected_clients.clear()
    server.stop()


@pytest.fixture
def source():
    return Source()


@pytest.fixture
def part(server, source):
    yield Replay(server.gui, source.flights()[0], source)
    server.gui.reset()


def by_hand(part, handle, value):
    """What a browser does whose user sets a widget."""
    gui = part.gui
    message = GuiUpdateMessage(handle._impl.uuid, {"value": value})
    asyncio.run_coroutine_threadsafe(gui._handle_gui_updates(0, message), gui._event_loop).result(
        WAIT
    )


def until(condition):
    end = time.monotonic() + WAIT
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_it_is_there_once_for_all_aircraft_of_a_record(source):
    first, second = source.flights()
    assert Replay.fits(first, source)
    assert not Replay.fits(second, source)
    source.clock = None
    assert not Replay.fits(first, source)


def test_the_slider_follows_the_clock(part, source):
    source.wall = 12.5
    part.show(None)
    assert part._slider.value == 10.5
    assert part._words.content == "**0:10.5** of 10:00.0"
    assert source.clock.playing


def test_the_slider_shows_whole_steps(part, source):
    """The field beside it has no room for more."""
    source.wall = 45.0996
    part.show(None)
    assert (part._slider.min, part._slider.value, part._slider.max) == (-2.0, 43.1, 600.0)


def test_who_moves_the_slider_moves_the_clock(part, source):
    by_hand(part, part._slider, 300.0)
    until(lambda: source.clock.time == 300.0)
    source.wall = 5.0
    assert source.clock.time == 305.0


def test_what_no_page_sends_moves_nothing(part, source, capfd):
    source.wall = 12.5
    by_hand(part, part._slider, float("nan"))
    by_hand(part, part._speed, "of nobody")
    by_hand(part, part._jumps, "of nobody")
    by_hand(part, part._slider, 100.0)
    until(lambda: source.clock.time == 100.0)
    part.show(None)
    assert part._speed.value == "1x"
    assert capfd.readouterr().err == ""


def test_the_slider_is_left_to_the_hand_that_moves_it(part, source, monkeypatch):
    by_hand(part, part._slider, 300.0)
    until(lambda: source.clock.time == 300.0)
    source.wall = 5.0
    monkeypatch.setattr(replay, "HAND", float("inf"))
    part.show(None)
    assert part._slider.value == 300.0
    monkeypatch.setattr(replay, "HAND", 0.0)
    part.show(None)
    assert part._slider.value == 305.0


def test_play_and_pause(part, source):
    assert part._button.label == "pause"
    by_hand(part, part._button, True)
    until(lambda: not source.clock.playing and part._button.label == "play")
    source.wall = 50.0
    part.show(None)
    assert part._slider.value == -2.0
    by_hand(part, part._button, True)
    until(lambda: source.clock.playing and part._button.label == "pause")


def test_speed_changes_where_the_record_stands(part, source):
    source.wall = 10.0
    by_hand(part, part._speed, "5x")
    until(lambda: source.clock.rate == 5.0)
    assert source.clock.time == 8.0
    source.wall = 11.0
    assert source.clock.time == 13.0
    source.clock.pause()
    by_hand(part, part._speed, "2x")
    until(lambda: source.clock.rate == 2.0)
    assert not source.clock.playing
    assert source.clock.time == 13.0


def test_jumps_stay_within_the_record(part, source):
    source.clock.pause()
    by_hand(part, part._jumps, "+1 min")
    until(lambda: source.clock.time == 58.0)
    for _ in range(2):
        by_hand(part, part._jumps, "-1 min")
    until(lambda: source.clock.time == -2.0)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(0.0, "0:00.0"), (-3.25, "-0:03.2"), (59.96, "1:00.0"), (7384.5, "2:03:04.5")],
)
def test_time_in_words(seconds, words):
    assert clock_words(seconds) == words
