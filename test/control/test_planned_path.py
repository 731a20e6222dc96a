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

"""Paths against the vehicle's exact motion and against a fine integration of its response."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.planned_path import PathPlanner
from uav_tracking_mpc.dynamics import vehicle

START = np.array([100.0, -50.0, 120.0, 2.5, 0.1, 22.0])
WIND, AT_ONCE = np.array([5.0, -3.0, 0.5]), np.zeros(3)
RATES = np.array([0.2, -0.05, 0.3])
STEP = 0.5  # s


def plan(count, seed=0):
    random = np.random.default_rng(seed)
    return random.uniform(-1.0, 1.0, size=(count, 3)) * (0.5, 0.1, 1.0)


@pytest.mark.parametrize("count", [1, 2, 20])
def test_without_a_lag_it_is_the_vehicles_motion_in_moving_air(count):
    inputs = plan(count)
    path = PathPlanner().path(START, RATES, WIND, inputs, STEP, AT_ONCE, AT_ONCE)
    state, drift = START, np.zeros(3)
    for stage in range(count + 1):
        found = path.states[stage]
        np.testing.assert_allclose(found[:3], state[:3] + drift, atol=1e-3)
        np.testing.assert_allclose(np.cos(found[3:5]), np.cos(state[3:5]), atol=1e-9)
        assert found[5] == pytest.approx(state[5])
        ground = vehicle.velocity(state) + WIND
        np.testing.assert_allclose(path.ground_velocities[stage], ground, atol=1e-9)
        if stage < count:
            state, drift = vehicle.advance(state, inputs[stage], STEP), drift + STEP * WIND


def test_lag_and_dead_time_are_flown_through():
    lags, dead_times = np.array([0.3, 0.13, 0.0]), np.array([0.17, 0.2, 0.6])
    inputs, fine = plan(8), 1000
    path = PathPlanner().path(START, RATES, WIND, inputs, STEP, lags, dead_times)
    state, rates, position = START[3:].copy(), RATES.copy(), START[:3].copy()
    small = STEP / fine
    for tick in range(len(inputs) * fine):
        if tick % fine == 0:
            found = path.states[tick // fine]
            np.testing.assert_allclose(found[3:], state, atol=2e-3)
            np.testing.assert_allclose(found[:3], position, atol=0.2)
        middle = (tick + 0.5) * small
        for axis in range(3):
            if middle >= dead_times[axis]:
                wanted = inputs[int((middle - dead_times[axis]) / STEP), axis]
                share = -np.expm1(-small / lags[axis]) if lags[axis] else 1.0
                rates[axis] += share * (wanted - rates[axis])
        half = state + 0.5 * small * rates
        position += small * (vehicle.velocity([0.0, 0.0, 0.0, *half]) + WIND)
        state += small * rates


def test_velocities_are_the_slope_of_the_positions():
    lags = np.full(3, 0.3)
    path = PathPlanner().path(START, RATES, WIND, plan(40), 0.02, lags, AT_ONCE)
    slopes = (path.states[2:, :3] - path.states[:-2, :3]) / 0.04
    np.testing.assert_allclose(path.ground_velocities[1:-1], slopes, atol=0.02)


def test_it_begins_where_the_aircraft_is_and_as_it_flies():
    path = PathPlanner().path(START, RATES, WIND, plan(5), STEP, np.ones(3), np.ones(3))
    np.testing.assert_array_equal(path.states[0], START)
    np.testing.assert_allclose(path.ground_velocities[0], vehicle.velocity(START) + WIND)


def test_one_planner_takes_plans_of_any_form():
    planner = PathPlanner()
    for count, step, lag in ((5, 0.5, 0.0), (1, 1.0, 0.3), (5, 0.5, 0.0), (5, 0.4, 0.2)):
        arguments = START, RATES, WIND, plan(count), step, np.full(3, lag), AT_ONCE
        first, alone = planner.path(*arguments), PathPlanner().path(*arguments)
        np.testing.assert_array_equal(first.states, alone.states)
        again = planner.path(START + 1.0, *arguments[1:])
        assert not np.array_equal(again.states, first.states)  # what was given out stays
        np.testing.assert_array_equal(first.states, alone.states)


@given(st.lists(st.tuples(*[st.floats(-10.0, 10.0)] * 3), min_size=1, max_size=30))
def test_of_finite_inputs_it_is_finite(inputs):
    path = PathPlanner().path(START, RATES, WIND, np.array(inputs), 1.0, np.full(3, 1e-9), AT_ONCE)
    assert np.isfinite(path.states).all()
    assert np.isfinite(path.ground_velocities).all()
