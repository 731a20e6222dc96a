"""The lagged vehicle in a drift, against numerical integration and the vehicle without lag."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from uav_tracking_mpc.dynamics.lagged_vehicle import LAG_STATES, advance

from uav_tracking_mpc.dynamics import vehicle

LAG = (0.3, 0.13, 0.16)
START = [200.0, -80.0, 40.0, 2.9, 0.05, 22.0, 0.1, -0.05, 0.4]
INPUTS = [-0.3, 0.2, -1.0]
DRIFT, DRIFT_RATE = [6.0, -3.0, 0.5], [0.2, 0.1, -0.1]


def integrated(state, inputs, duration, lag, drift, rate):
    """SciPy's answer to the equations of the module."""

    def rates(time, state):
        psi, chi, v = state[3:6]
        level = v * np.cos(chi)
        air = np.array([level * np.cos(psi), level * np.sin(psi), v * np.sin(chi)])
        flown = state[6:] if len(lag) else inputs
        ground = air + np.array(drift) + time * np.array(rate)
        lagged = (np.array(inputs) - state[6:]) / np.array(lag) if len(lag) else []
        return np.concatenate([ground, flown, lagged])

    return solve_ivp(rates, (0.0, duration), state, rtol=1e-11, atol=1e-11).y[:, -1]


@pytest.mark.parametrize(("lag", "size"), [(LAG, 9), ((), 6)])
def test_it_is_the_solution_of_its_equations(lag, size):
    """At a short step: what is left is Simpson's error in the position, all else is exact."""
    flown = advance(START[:size], INPUTS, 0.05, lag, DRIFT, DRIFT_RATE)
    expected = integrated(START[:size], INPUTS, 0.05, lag, DRIFT, DRIFT_RATE)
    np.testing.assert_allclose(flown[:3], expected[:3], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(flown[3:], expected[3:], rtol=0.0, atol=1e-9)


def test_heading_path_angle_airspeed_and_rates_are_exact_at_any_step():
    flown = advance(START, INPUTS, 3.0, LAG, DRIFT, DRIFT_RATE)
    expected = integrated(START, INPUTS, 3.0, LAG, DRIFT, DRIFT_RATE)
    np.testing.assert_allclose(flown[3:], expected[3:], rtol=0.0, atol=1e-8)


def test_the_position_is_of_fourth_order_in_the_step():
    errors = []
    for count in (2, 4, 8):
        state = list(START)
        for k in range(count):
            now = np.array(DRIFT) + k / count * np.array(DRIFT_RATE)
            state = advance(state, INPUTS, 1.0 / count, LAG, now, DRIFT_RATE)
        expected = integrated(START, INPUTS, 1.0, LAG, DRIFT, DRIFT_RATE)
        errors.append(np.abs(np.array(state[:3]) - expected[:3]).max())
    assert errors[0] < 1e-2  # m, at a step of 0.5 s
    assert 12.0 < errors[0] / errors[1] < 22.0
    assert 12.0 < errors[1] / errors[2] < 22.0


def test_without_lag_and_drift_it_is_the_vehicle():
    flown = advance(START[:6], INPUTS, 0.05, (), np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(flown, vehicle.advance(START[:6], INPUTS, 0.05), atol=1e-6)


def test_a_short_lag_is_nearly_none():
    settled = [*START[:6], *INPUTS]
    flown = advance(settled, INPUTS, 0.5, (1e-3,) * 3, DRIFT, DRIFT_RATE)
    expected = advance(START[:6], INPUTS, 0.5, (), DRIFT, DRIFT_RATE)
    np.testing.assert_allclose(flown[:6], expected, atol=1e-12)
    assert len(LAG_STATES) == len(flown) - 6


@given(st.floats(0.01, 0.5), st.lists(st.floats(-0.5, 0.5), min_size=3, max_size=3))
def test_numbers_and_symbols_give_the_same(duration, inputs):
    state = ca.SX.sym("x", 9)
    symbolic = advance(ca.vertsplit(state), inputs, duration, LAG, DRIFT, DRIFT_RATE, symbolic=True)
    evaluate = ca.Function("f", [state], [ca.vertcat(*symbolic)])
    numbers = advance(START, inputs, duration, LAG, DRIFT, DRIFT_RATE)
    np.testing.assert_allclose(np.array(evaluate(START)).ravel(), numbers, rtol=1e-13, atol=1e-13)
