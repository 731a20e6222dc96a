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

"""The lagged vehicle in a drift, against numerical integration and the vehicle without lag."""

import math

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.dynamics.energy_hold import hold
from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleState
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Held, Lagged

LAG = (0.3, 0.13, 0.16)
START = VehicleState(200.0, -80.0, 40.0, 2.9, 0.05, 22.0, 0.1, -0.05, 0.4)
INPUTS = [-0.3, 0.2, -1.0]
DRIFT = Drift([6.0, -3.0, 0.5], [0.2, 0.1, -0.1])


def advance(state, inputs, duration, lag=LAG, drift=DRIFT):
    model = Lagged(lag)
    return model.step(state, inputs, duration, model.numbers(duration), drift)


def integrated(state, inputs, duration, drift):
    """SciPy's answer to the equations of the module."""

    def rates(time, state):
        _, _, _, psi, chi, v, *flown = state
        air = np.array(vehicle.air_velocity(psi, chi, v, np))
        ground = air + np.array(drift.velocity) + time * np.array(drift.rate)
        lagged = (np.array(inputs) - flown) / np.array(LAG)
        return np.concatenate([ground, flown, lagged])

    return solve_ivp(rates, (0.0, duration), state, rtol=1e-11, atol=1e-11).y[:, -1]


@pytest.mark.parametrize(("duration", "error"), [(0.05, 1e-6), (3.0, 1.0)])
def test_it_is_the_solution_of_its_equations(duration, error):
    """At a short step; at any, all but the position, which has Simpson's error."""
    flown = advance(START, INPUTS, duration)
    expected = integrated(START, INPUTS, duration, DRIFT)
    np.testing.assert_allclose(flown[:3], expected[:3], rtol=0.0, atol=error)
    np.testing.assert_allclose(flown[3:], expected[3:], rtol=0.0, atol=1e-8)


def test_the_position_is_of_fourth_order_in_the_step():
    errors = []
    for count in (2, 4, 8):
        state = START
        for k in range(count):
            now = np.array(DRIFT.velocity) + k / count * np.array(DRIFT.rate)
            state = advance(state, INPUTS, 1.0 / count, drift=Drift(now, DRIFT.rate))
        expected = integrated(START, INPUTS, 1.0, DRIFT)
        errors.append(np.abs(np.array(state[:3]) - expected[:3]).max())
    assert errors[0] < 1e-2  # m, at a step of 0.5 s
    assert 12.0 < errors[0] / errors[1] < 22.0
    assert 12.0 < errors[1] / errors[2] < 22.0


def test_without_lag_and_drift_it_is_the_vehicle():
    """Whatever rates were flown before."""
    still = Drift(np.zeros(3), np.zeros(3))
    flown = advance(START, INPUTS, 0.05, (0.0, 0.0, 0.0), still)
    np.testing.assert_allclose(flown[:6], vehicle.advance(START[:6], INPUTS, 0.05), atol=1e-6)
    np.testing.assert_allclose(flown[6:], INPUTS)


def test_a_measurement_gives_the_state_relative_to_the_target():
    state = Lagged().initial([5.0, 7.0, 9.0, 0.1, 0.2, 20.0], [1.0, 2.0, 3.0], [0.3, 0.4, 0.5])
    assert state == VehicleState(4.0, 5.0, 6.0, 0.1, 0.2, 20.0, 0.3, 0.4, 0.5)


@given(st.floats(0.01, 0.5), st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3))
def test_numbers_and_symbols_give_the_same(duration, inputs):
    state = ca.SX.sym("x", 9)
    symbolic = advance(VehicleState(*ca.vertsplit(state)), inputs, duration)
    evaluate = ca.Function("f", [state], [ca.vertcat(*symbolic)])
    numbers = advance(START, inputs, duration)
    np.testing.assert_allclose(
        evaluate(np.array(START)).full().ravel(), numbers, rtol=1e-13, atol=1e-13
    )


MODEL = Held(rate_lag=LAG, hold_time=(4.0, 0.8, 3.0), hold_climb_max=4.0)
STATE = VehicleState(200.0, -80.0, 40.0, 2.9, 0.05, 20.0, 0.1, -0.05, 0.4)
DRIFT_HELD = [6.0, -3.0, 0.5]


def held(state, altitude=60.0, airspeed=22.0, drift=DRIFT_HELD):
    return MODEL.held(state, altitude, airspeed, MODEL.numbers(0.4), drift)


def test_the_autopilot_flies_its_law_towards_what_it_is_told():
    climb_rate = 20.0 * math.sin(0.05) + 0.5
    expected = hold(20.0, climb_rate, 0.05, 20.0, 2.0, MODEL.hold_constants, math)
    np.testing.assert_allclose(held(STATE), expected)


def test_a_step_is_that_of_the_lagged_vehicle():
    inputs, drift = [0.1, *held(STATE)], Drift(DRIFT_HELD, [0.0, 0.0, 0.0])
    lagged = Lagged(LAG)
    expected = lagged.step(STATE, inputs, 0.4, lagged.numbers(0.4), drift)
    assert MODEL.step(STATE, inputs, 0.4, MODEL.numbers(0.4), drift) == expected


def test_numbers_arrays_and_symbols_give_the_same():
    symbols = ca.SX.sym("x", 9)
    function = ca.Function("held", [symbols], held(VehicleState(*ca.vertsplit(symbols))))
    symbolic = [float(value) for value in function(np.array(STATE))]
    np.testing.assert_allclose(symbolic, held(STATE), rtol=1e-13)
    stacked = VehicleState(*np.tile(np.array(STATE)[:, np.newaxis], 4))
    drift = np.tile(np.array(DRIFT_HELD)[:, np.newaxis], 4)
    np.testing.assert_allclose(held(stacked, drift=drift)[0], held(STATE)[0])


@pytest.mark.parametrize("start", [-60.0, 40.0])
def test_step_by_step_the_altitude_comes_back(start):
    state = VehicleState(0.0, 0.0, 60.0 + start, 0.0, 0.0, 18.0, 0.0, 0.0, 0.0)
    numbers, drift = MODEL.numbers(0.4), Drift([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    for _ in range(200):
        state = MODEL.step(state, [0.0, *held(state, drift=[0.0, 0.0, 1.0])], 0.4, numbers, drift)
    assert state.z == pytest.approx(60.0, abs=0.01)
    assert state.airspeed == pytest.approx(22.0, abs=0.01)
    assert 22.0 * math.sin(state.path_angle) == pytest.approx(-1.0, abs=0.01)
