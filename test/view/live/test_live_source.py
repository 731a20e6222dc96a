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

"""Aircraft that fly now: waited for, seen, remembered for some minutes."""

import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from heard_flight import STATE, aircraft
from processes import DOMAIN, environment

from uav_tracking_mpc.view.live import live_source
from uav_tracking_mpc.view.live.live_source import PAST_PERIOD, PAST_SPAN, LiveFlight


@pytest.fixture
def flight(monkeypatch):
    """A flight, and what makes it fly on to a time in [s]."""
    heard, known = aircraft(), SimpleNamespace(value=None)
    monkeypatch.setattr(live_source, "RosSteering", lambda node, namespace: None)
    watcher = SimpleNamespace(aircraft={"/fleet/red": heard}, parameters={"/fleet/red": known})
    live, now = LiveFlight(watcher, "/fleet/red"), [1000.0]
    monkeypatch.setattr(live_source.time, "monotonic", lambda: now[0])

    def fly(stamp):
        heard.state.value = replace(STATE, stamp=stamp)
        return live.sight

    return SimpleNamespace(live=live, fly=fly, known=known)


def test_its_name_is_one_word(flight):
    assert flight.live.name == "fleet.red"


def test_its_parameters_are_those_of_its_controller(flight):
    assert flight.live.tracking is None
    flight.known.value = parameters = object()
    assert flight.live.tracking is parameters


def test_the_past_is_thin_and_without_plans(flight):
    for stamp in np.arange(0.0, 10.0, 0.02):
        flight.fly(stamp)
    past = flight.live.past(4.0)
    times = np.array([sight.time for sight in past])
    assert np.all(np.diff(times) >= PAST_PERIOD - 1e-9)
    assert np.all(np.diff(times) < 2.0 * PAST_PERIOD)
    assert 3.5 < times[-1] - times[0] <= 4.0
    assert all(sight.plan is None and not sight.statuses for sight in past)
    assert flight.live.sight.plan is not None


def test_the_past_does_not_grow_without_end(flight):
    for stamp in np.arange(0.0, 3.0 * PAST_SPAN, PAST_PERIOD):
        flight.fly(stamp)
    assert len(flight.live.past(np.inf)) == round(PAST_SPAN / PAST_PERIOD)


def test_when_time_begins_anew_the_past_does(flight):
    for stamp in (10.0, 20.0, 5.0, 6.0):
        flight.fly(stamp)
    assert [sight.time for sight in flight.live.past(np.inf)] == [5.0, 6.0]


# In a process of its own, as the page is: that of the tests holds the participants of many others.
WATCHER = """
import sys, threading, time
import numpy as np
import rclpy
from uav_tracking_mpc.nodes.conversions import set_odometry
from uav_tracking_mpc.nodes.topics import ODOMETRY
from uav_tracking_mpc.view.live.live_source import LiveSource

domain = int(sys.argv[1])
source = LiveSource(domain)
assert source.flights() == []
assert source.words == f"waiting for a flight in domain {domain}"
context = rclpy.Context()
context.init(args=[], domain_id=domain)
sender = rclpy.create_node("sender", namespace="red", context=context)
states = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
message, deadline = ODOMETRY.type(), time.monotonic() + 60.0
while source.words and time.monotonic() < deadline:
    set_odometry(message, 1_000_000_000, np.array([1.0, 2.0, 3.0, 0.0, 0.0, 20.0]), np.zeros(3))
    states.publish(message)
    time.sleep(0.05)
words, (flight,) = source.words, source.flights()
same, name, position = source.flights()[0] is flight, flight.name, flight.sight.position
source.close()
left = {"flight_watcher", "past of flights"} & {t.name for t in threading.enumerate()}
sender.destroy_node()
context.try_shutdown()
assert (words, same, name, list(position), left) == ("", True, "red", [1.0, 2.0, 3.0], set())
"""


@pytest.mark.nodes
def test_a_source_waits_until_something_flies_and_ends():
    words = [sys.executable, "-c", WATCHER, DOMAIN]
    finished = subprocess.run(words, capture_output=True, text=True, env=environment())
    assert finished.returncode == 0, finished.stderr
