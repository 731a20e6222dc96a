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

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from uav_tracking_mpc.dynamics.vehicle import advance, velocity

STATES = st.tuples(
    st.floats(-500, 500),
    st.floats(-500, 500),
    st.floats(-100, 100),
    st.floats(-3.1, 3.1),
    st.floats(-1.0, 1.0),
    st.floats(0, 30),
)
INPUTS = st.tuples(st.floats(-1, 1), st.floats(-0.5, 0.5), st.floats(-2, 2))


def equations(state, inputs):
    """(3a)-(3f), in the order (x, y, z, psi, chi, v)."""
    _, _, _, psi, chi, v = state
    u_psi, u_chi, u_v = inputs
    return [
        v * np.cos(chi) * np.cos(psi),
        v * np.cos(chi) * np.sin(psi),
        v * np.sin(chi),
        u_psi,
        u_chi,
        u_v,
    ]


@given(STATES, INPUTS, st.floats(0.01, 5.0))
def test_advance_solves_the_kinematics(state, inputs, duration):
    oracle = solve_ivp(
        lambda t, s: equations(s, inputs),
        (0.0, duration),
        state,
        method="DOP853",
        rtol=1e-12,
        atol=1e-11,
    ).y[:, -1]
    end = advance(state, inputs, duration)
    np.testing.assert_allclose(end[:3], oracle[:3], atol=1e-8)
    np.testing.assert_allclose(np.exp(1j * end[3:5]), np.exp(1j * oracle[3:5]), atol=1e-10)
    assert end[5] == pytest.approx(oracle[5])


@given(STATES, INPUTS, st.floats(0.0, 3.0), st.floats(-3.0, 3.0))
def test_two_steps_are_one_long_step_backwards_too(state, inputs, first, second):
    halfway = advance(state, inputs, first)
    np.testing.assert_allclose(
        advance(halfway, inputs, second)[:3], advance(state, inputs, first + second)[:3], atol=1e-9
    )


@pytest.mark.parametrize("rate", [0.0, 1e-300, 1e-12, 1e-6, 0.4999, 0.5001])
def test_slow_turns_have_no_cancellation(rate):
    """A steady level turn is a circle of radius v / rate."""
    end = advance([0, 0, 0, 0, 0, 10.0], [rate, 0, 0], 1.0)
    exact_y = 10.0 * rate / 2.0 * np.sinc(rate / 2.0 / np.pi) ** 2
    assert end[1] == pytest.approx(exact_y, rel=1e-13, abs=0.0)


def test_velocity_is_the_right_side_of_the_position_equations():
    state = [1, 2, 3, 0.4, 0.2, 7.0]
    np.testing.assert_allclose(velocity(state), equations(state, (0, 0, 0))[:3])
