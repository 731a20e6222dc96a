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

"""The orbit that is flown in place of the one asked for is told, once, if it stays."""

from types import SimpleNamespace

import numpy as np
import pytest

from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.orbit_shortfall import OrbitShortfall
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate

WANTED = Orbit(300.0, 120.0, 22.0, "clockwise")


def told(orbits):
    """Words about orbits, (range, altitude, airspeed), flown for 5 s each."""
    events = EventLog()
    shortfall = OrbitShortfall(events)
    for k, orbit in enumerate(np.repeat(np.array(orbits), 50, axis=0)):
        shortfall.see(0.1 * k, SimpleNamespace(orbit=orbit), WANTED)
    return [event.words for event in events.take()]


def test_an_orbit_that_stays_is_told_once_and_its_end_too():
    words = told([(310.0, 125.0, 20.0)] * 6 + [(300.2, 120.3, 22.1)] * 3)
    assert words == [
        "limits and drift leave no orbit of 300.0 m at 120.0 m and 22.0 m/s: "
        "flying 310.0 m at 125.0 m and 20.0 m/s",
        "the orbit that was asked for is flown again",
    ]


@pytest.mark.parametrize(
    "orbits",
    [
        [(300.5, 121.0, 22.3)] * 6,
        [(500.0 - 50.0 * k, 120.0, 22.0) for k in range(5)],
        [(310.0, 120.0, 22.0)],
    ],
    ids=["next to it", "on the way", "for a moment"],
)
def test_the_orbit_asked_for_and_the_way_to_it_are_not_worth_a_word(orbits):
    assert told(orbits) == []


def test_a_gale_that_the_bank_cannot_hold_is_told_in_flight(monkeypatch):
    overrides = ["nmpc_controller.range=180", "uav_simulator.wind=[-12, 0, 0]",
                 "mission.duration=60", "target_publisher.motion=line",
                 "target_publisher.speed=5"]  # fmt: skip
    words = []
    monkeypatch.setattr(EventLog, "add", lambda self, level, text: words.append(text))
    simulate(load_configuration("small_uav", overrides))
    assert sum(text.startswith("limits and drift leave no orbit of 180.0 m") for text in words) == 1
