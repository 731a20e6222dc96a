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

"""What is heard is seen; silence of aircraft, controller and nodes is told in words."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from heard_flight import FIGURES, NOW, STATE, aircraft, nothing, report, said

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.nodes.heard_aircraft import Plan, Report
from uav_tracking_mpc.nodes.tracking_message import MODES
from uav_tracking_mpc.view.live.live_sight import GONE, SILENT, STALE, live_sight, node_statuses


def seen(heard, before=None):
    return live_sight(heard, before, node_statuses(heard, NOW), NOW)


def test_a_flight_is_seen_as_it_is_heard():
    sight = seen(aircraft(report(**{"latency [s]": 0.02, "mode": "optimal plan"})))
    assert sight.time == 50.0
    np.testing.assert_array_equal(sight.position, STATE.position)
    assert sight.airspeed == 17.0
    assert sight.bank == pytest.approx(math.atan(0.2 * 17.0 / GRAVITY))  # to the right
    np.testing.assert_array_equal(sight.wind, [3.0, -4.0, 0.0])
    np.testing.assert_array_equal(sight.target.position, [10.0, 20.0, 1.0])
    np.testing.assert_array_equal(sight.target.velocity, [1.0, -2.0, 0.0])
    np.testing.assert_array_equal(sight.target.measured, [9.0, 19.0, 0.0])
    np.testing.assert_array_equal(sight.target.truth, [10.5, 20.5, 1.0])
    assert sight.target.std == 0.4
    np.testing.assert_array_equal(sight.wanted.centre, [10.0, 20.0, 121.0])
    assert sight.wanted.radius == pytest.approx(math.sqrt(300.0**2 - 120.0**2))
    assert sight.flown.radius == 275.0
    assert sight.errors["range_error"] == 5.0 and "mode" not in sight.errors
    assert (sight.mode, sight.reason) == (FallbackMode.OPTIMAL, "")
    assert (sight.cost, sight.solve_time, sight.latency) == (7.0, 1e-3, 0.02)


def test_of_the_plan_what_is_not_yet_flown_is_seen():
    np.testing.assert_array_equal(seen(aircraft()).plan, np.arange(6.0, 15.0).reshape(3, 3))
    placeless = Plan(49.9, np.empty((0, 3)), np.empty(0))
    assert seen(aircraft(plan=said(placeless))).plan is None


def test_before_the_first_state_nothing_is_seen():
    assert seen(aircraft(state=nothing())) is None


def test_without_a_controller_aircraft_wind_and_target_are_seen():
    quiet = dict.fromkeys(("plan", "orbit", "figures", "cost", "solve_time"), nothing())
    sight = seen(aircraft(**quiet))
    assert (sight.mode, sight.reason) == (None, "")
    np.testing.assert_allclose(sight.wind, [3.0, 4.0, 0.0])  # of the wind triangle
    np.testing.assert_array_equal(sight.target.position, [9.0, 19.0, 0.0])  # as measured
    assert math.isnan(sight.target.std)
    assert sight.wanted is None and sight.flown is None and not sight.errors
    assert math.isnan(sight.cost)
    assert seen(aircraft(**quiet, airspeed=nothing())).wind is None


def test_a_controller_that_waits_says_why():
    waits = report(mode="silence", **{"mode reason": "no target position"})
    sight = seen(aircraft(waits, plan=nothing(), figures=nothing()))
    assert (sight.mode, sight.reason) == (None, "no target position")


def test_commands_that_end_are_a_silence_in_words():
    killed = aircraft(report(0.5, mode="optimal plan"), plan=said(None, STALE + 1.5))
    assert seen(killed).mode is FallbackMode.SILENCE
    assert seen(killed).reason == "nothing comes on uav/command for 3 s"
    stopped = report(0.5, mode="silence", **{"mode reason": "deactivated"})
    sight = seen(aircraft(stopped, plan=said(None, STALE + 1.5)))
    assert (sight.mode, sight.reason) == (FallbackMode.SILENCE, "deactivated")


@pytest.mark.parametrize("mode", [mode for mode in MODES if mode is not FallbackMode.SILENCE])
def test_the_mode_is_that_of_the_command_and_the_reason_that_of_the_report(mode):
    figures = said({**FIGURES, "mode": float(MODES.index(mode))})
    worse = report(mode="loiter law", **{"mode reason": "target position is lost"})
    sight = seen(aircraft(worse, figures=figures))
    assert sight.mode is mode
    assert sight.reason == ("target position is lost" if mode is FallbackMode.LOITER else "")


def test_without_a_target_the_mode_is_that_of_the_report():
    level = report(mode="wings level", **{"mode reason": "no target position"})
    sight = seen(aircraft(level, figures=nothing()))
    assert (sight.mode, sight.reason) == (FallbackMode.HOLD, "no target position")


def test_an_aircraft_that_falls_silent_stays_where_it_was():
    before = seen(aircraft())
    sight = seen(aircraft(state=said(STATE, STALE + 1.5)), before)
    np.testing.assert_array_equal(sight.position, STATE.position)
    assert sight.mode is FallbackMode.SILENCE
    assert sight.reason == "nothing comes on uav/odometry for 3 s"
    assert sight.plan is None and sight.flown is None


def test_while_time_stands_still_the_controller_says_so():
    stands = report(words="simulated time stands still", mode="optimal plan")
    sight = seen(aircraft(stands, state=said(STATE, STALE + 1.5)), seen(aircraft()))
    assert (sight.mode, sight.reason) == (FallbackMode.OPTIMAL, "simulated time stands still")


def test_a_state_that_cannot_be_used_is_told():
    bad = SimpleNamespace(value=None, arrival=NOW, trouble="uav/odometry: pose.orientation")
    sight = seen(aircraft(state=bad), seen(aircraft()))
    assert (sight.mode, sight.reason) == (FallbackMode.SILENCE, "uav/odometry: pose.orientation")


def test_a_node_that_says_no_more_is_silent():
    heard = aircraft(report(0.5), report(GONE + 1.0, node="uav_simulator", words="flying"))
    controller, simulator = node_statuses(heard, NOW)
    assert (controller.level, controller.words) == (1, "fine")
    assert (simulator.level, simulator.words) == (SILENT, "silent, before: flying")


@pytest.mark.parametrize("values", [{"mode": "sideways"}, {"latency [s]": "long"}, {}])
def test_reports_of_others_are_survived(values):
    strange = Report("nmpc_controller", 0, "", {**values, "orbit range [m]": "wide"}, NOW)
    sight = seen(aircraft(strange))
    assert sight.wanted is None and math.isnan(sight.latency)
    assert sight.mode is FallbackMode.OPTIMAL
