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

"""The flight problem where the autopilot itself holds altitude and airspeed."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.dynamics.vehicle_models import VehicleState
from uav_tracking_mpc.estimation.situation import steady_forecast
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation

HELD = small_uav.parameters("autopilot_holds=true", "direction=counter_clockwise")


@lru_cache
def shared():
    return FlightFormulation(HELD)


def formulation():
    flight = shared()
    flight.reset()
    flight.change(HELD)
    return flight


def plans(flight, now, orbit=HELD.orbit, count=1):
    ahead = steady_forecast(now, HELD.horizon)
    elapsed = [None, *[0.05] * (count - 1)]
    return [flight.solve(now, ahead, orbit, each) for each in elapsed]


def test_the_bank_alone_is_an_input_and_what_it_has_no_say_in_is_left_out():
    problem, free = formulation().flight.problem, small_uav.problem()
    assert (problem.nu, free.nu) == (1, 3)
    assert "held" not in small_uav.flight().where
    assert problem.terminal_equality.numel() == 3  # range, bearing and turn rate
    names = {inequality.name for inequality in problem.stage_inequalities}
    assert "distance" in names
    assert names.isdisjoint({"airspeed", "path angle", "height"})


def test_on_the_orbit_nothing_is_paid():
    (plan,) = plans(formulation(), small_uav.on_orbit(HELD, 0.3, 1.0))
    assert plan.solution.converged
    assert plan.solution.cost == pytest.approx(0.0, abs=1e-6)
    np.testing.assert_allclose(plan.inputs[:, 0], 22.0 / HELD.orbit.radius, atol=1e-6)
    np.testing.assert_allclose(plan.inputs[:, 1:], 0.0, atol=1e-9)


@pytest.mark.parametrize("height", [40.0, 119.0, 250.0])
def test_from_any_height_there_is_a_plan_that_holds_the_range_in_the_climb(height):
    """Within 1 %, as the bounds of bank and roll rate let it: 2.9 m from 130 m too high."""
    radius = np.sqrt(300.0**2 - height**2)
    start = small_uav.situation(radius, 0.0, height, np.pi / 2.0, rates=(22.0 / radius, 0.0, 0.0))
    plan = plans(formulation(), start, count=3)[-1]
    assert plan.solution.converged
    x, y, z = plan.solution.states[:, :3].T
    assert abs(z[-1] - 120.0) < 0.7 * abs(height - 120.0) + 1.0
    assert np.abs(np.sqrt(x**2 + y**2 + z**2) - 300.0).max() < 0.01 * 300.0


def test_what_is_not_commanded_is_what_the_autopilot_is_expected_to_want():
    start = small_uav.situation(450.0, 30.0, 90.0, 2.8, 0.05, 20.0, drift=(5.0, 2.0, 0.3))
    flight = formulation()
    (plan,) = plans(flight, start)
    model, states = HELD.vehicle, plan.solution.states
    for stage in (0, 7, 21):
        expected = model.held(
            VehicleState(*states[stage]), 120.0, 22.0, model.numbers(0.4), [5.0, 2.0, 0.3]
        )
        np.testing.assert_allclose(plan.inputs[stage, 1:], expected, rtol=1e-9)


@pytest.mark.parametrize("distance", [100.0, 350.0, 1500.0])
def test_the_autopilot_is_told_the_wanted_altitude_and_airspeed_from_wherever(distance):
    start = small_uav.situation(distance, 0.0, 80.0, 1.0, 0.1, 25.0)
    plan = plans(formulation(), start, count=2)[-1]
    _, altitude, airspeed = plan.orbit
    assert altitude == pytest.approx(120.0, abs=1e-3)
    assert airspeed == pytest.approx(22.0, abs=1e-3)


def test_in_a_wind_that_leaves_no_such_orbit_it_is_told_a_higher_airspeed_and_flown_with_it():
    start = small_uav.situation(350.0, 0.0, 120.0, 1.5, drift=(0.0, 21.5, 0.0))
    flight = formulation()
    plan = plans(flight, start, count=3)[-1]
    _, _, airspeed = plan.orbit
    assert airspeed > 22.5
    _, u_v = HELD.vehicle.held(
        VehicleState(*plan.solution.states[0]), 120.0, airspeed, HELD.vehicle.numbers(0.4), [0] * 3
    )
    assert plan.inputs[0, 2] == pytest.approx(u_v, rel=1e-3)


def test_what_was_told_is_forgotten_with_the_plan():
    flight = formulation()
    start = small_uav.situation(350.0, 0.0, 120.0, 1.5, drift=(0.0, 21.5, 0.0))
    plans(flight, start, count=2)
    flight.reset()
    data = flight.data(steady_forecast(start, HELD.horizon), HELD.orbit)
    np.testing.assert_allclose(data[0][flight.flight.where["held"]], [120.0, 22.0])


def test_in_gusts_the_turn_rate_is_changed_more_gently():
    """Plans from a metre inside the orbit, in calm air and in ever stronger gusts."""
    radius = HELD.orbit.radius
    rates = (22.0 / radius, 0.0, 0.0)
    start = small_uav.situation(radius - 1.0, 0.0, 120.0, np.pi / 2.0, rates=rates)
    flight = formulation()
    ahead = steady_forecast(start, HELD.horizon)
    changes = []
    for walk in (0.0, 0.1, 0.5, 1.0, 5.0, np.inf):
        flight.reset()
        plan = flight.solve(start, ahead._replace(gust_walk=walk), HELD.orbit, None)
        assert plan.solution.converged
        changes.append(np.abs(np.diff(plan.inputs[:, 0])).max())
    assert changes[0] == changes[1] > 1.4 * changes[2] > 1.4**2 * changes[3]
    assert changes[3] == changes[4] == changes[5]


def test_constants_of_the_autopilot_may_change_in_flight():
    start = small_uav.situation(450.0, 30.0, 90.0, 2.8)
    flight = formulation()
    (before,) = plans(flight, start)
    flight.change(replace(HELD, hold_time=(10.0, 1.0, 5.0)))
    (after,) = plans(flight, start)
    assert after.solution.states[-1, 2] < before.solution.states[-1, 2] - 2.0
