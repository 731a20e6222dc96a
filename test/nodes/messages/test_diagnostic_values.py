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

"""What nodes say of themselves in diagnostics, written and read."""

import dataclasses
import math

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.adaptation import ResponseAdaptation
from uav_tracking_mpc.control.event import EventLog
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.estimation.air_estimate import AirEstimate
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.response_estimator import CHANNELS, ChannelResponse
from uav_tracking_mpc.nodes.messages.diagnostic_values import (
    MODE,
    REASON,
    air_values,
    mode_changes,
    orbit_changes,
    orbit_values,
    reported_mode,
    reported_orbit,
    response_values,
    with_silences,
)


def test_every_value_has_its_unit_and_is_the_filters():
    air, wind = AirEstimate(), np.array([3.0, 4.0, 0.0])
    for k in range(200):
        time = 0.05 * k
        heading = 0.07 * time
        ground = 22.0 * np.array([np.cos(heading), np.sin(heading), 0.0]) + wind
        seen = Measurement(time, np.zeros(3), ground, heading, 0.0, 0.07)
        air.update(seen, seen.state(22.0), np.array([0.07, 0.0, 0.0]), 0.0, False)
    values = air_values(air)
    assert all(key.endswith(("]", " sensor")) for key in values)
    assert values["airspeed sensor"] == "used"
    assert values["mean wind north [m/s]"] == air.state.wind[1]
    assert values["gust up [m/s]"] == air.state.gust[2]
    assert values["bias of ground velocity east [m/s]"] == air.state.bias[0]
    assert values["airspeed reads too much by [%]"] == pytest.approx(100.0 * air.state.alpha[0])
    assert values["bias of heading [deg]"] == pytest.approx(np.degrees(air.state.beta[0]))


def test_estimates_with_deviations_and_what_is_flown_by():
    response = ResponseAdaptation(small_uav.parameters(), EventLog())
    response.estimator.channels[0] = ChannelResponse(
        0.31, 0.16, 0.9, 0.02, 0.03, 0.01, trusted=True
    )
    values = response_values(response)
    assert values["turn rate lag estimated [s]"] == 0.31
    assert values["turn rate lag deviation [s]"] == 0.02
    assert values["turn rate dead time deviation [s]"] == 0.03
    assert values["turn rate lag and dead time estimated [s]"] == 0.47
    assert values["turn rate gain estimated"] == 0.9
    assert values["turn rate response trusted"] is True
    assert values["acceleration response trusted"] is False
    for axis, name in enumerate(CHANNELS):
        assert values[f"{name} lag flown by [s]"] == small_uav.parameters().rate_lag[axis]
    assert values["limit cycle of the turn rate"] == "none"


def test_without_estimation_only_what_is_flown_by():
    parameters = dataclasses.replace(small_uav.parameters(), response_estimation=False)
    values = response_values(ResponseAdaptation(parameters, EventLog()))
    assert not any("estimated" in key for key in values)
    assert values["turn rate dead time flown by [s]"] == parameters.dead_time[0]


OPTIMAL, LOITER = FallbackMode.OPTIMAL, FallbackMode.LOITER
SECOND = 1_000_000_000  # ns


@pytest.mark.parametrize("mode", FallbackMode)
def test_every_mode_comes_back(mode):
    assert reported_mode({MODE: mode.value, REASON: "why"}) == (mode, "why")


@pytest.mark.parametrize("values", [{}, {MODE: "upside down"}, {"reason": "why"}])
def test_a_report_without_a_mode(values):
    assert reported_mode(values) is None


def test_only_changes_count_and_only_those_of_the_flight():
    reports = [
        (0, FallbackMode.SILENCE, "no target position"),
        (2 * SECOND, OPTIMAL, ""),
        (3 * SECOND, OPTIMAL, ""),
        (4 * SECOND, LOITER, "target position is lost"),
        (5 * SECOND, LOITER, "target position is lost"),
        (6 * SECOND, OPTIMAL, ""),
        (9 * SECOND, FallbackMode.SILENCE, "shut down"),
    ]
    assert mode_changes(reports, SECOND, 8 * SECOND) == (
        (0.0, OPTIMAL, ""),
        (3.0, LOITER, "target position is lost"),
        (5.0, OPTIMAL, ""),
    )
    assert mode_changes([], 0, SECOND) == ()


def test_a_controller_that_is_gone_is_silent_although_nobody_says_so():
    """Killed at 3 s, back at 9 s; disengaged at 12 s, as it says itself; killed again at 19 s."""
    silent = FallbackMode.SILENCE
    reports = [(0, OPTIMAL, ""), (9 * SECOND, LOITER, "no target yet"), (10 * SECOND, OPTIMAL, "")]
    reports += [(12 * SECOND, silent, "disengaged"), (15 * SECOND, OPTIMAL, "")]
    spans = ((0, 3), (9, 12), (15, 19))
    commands = [k * SECOND // 2 for first, last in spans for k in range(2 * first, 2 * last + 1)]
    told = with_silences(reports, commands, 24 * SECOND)
    changes = mode_changes(told, 0, 24 * SECOND)
    assert [(round(begin, 6), mode, reason) for begin, mode, reason in changes] == [
        (0.0, OPTIMAL, ""),
        (3.0, silent, "no command came"),
        (9.0, LOITER, "no target yet"),
        (10.0, OPTIMAL, ""),
        (12.0, silent, "disengaged"),
        (15.0, OPTIMAL, ""),
        (19.0, silent, "no command came"),
    ]


FIRST = Orbit(300.0 + math.pi, 120.0, 22.0 / 7.0, COUNTER_CLOCKWISE)
OTHER = Orbit(350.0, 100.0, 20.0)


def test_there_and_back():
    values = {key: str(value) for key, value in orbit_values(FIRST).items()}
    assert reported_orbit(values) == FIRST


@pytest.mark.parametrize("values", [{}, {"orbit range [m]": "nan"}, {"direction": "up"}])
def test_what_holds_no_orbit(values):
    assert reported_orbit(values) is None


def test_only_changes_of_the_orbit_count():
    reports = [(5, OTHER), (1_000_000_000, FIRST), (2_000_000_000, FIRST), (3_000_000_000, OTHER)]
    assert orbit_changes(reports, 500_000_000) == ((0.5, FIRST), (2.5, OTHER))
    assert orbit_changes([], 0) == ()
