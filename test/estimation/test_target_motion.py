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
from scipy.linalg import expm

from uav_tracking_mpc.estimation.target_track import (
    FADE_TIME,
    MANOEUVRE_TIME,
    TURN,
    bridged,
    singer_motion,
)

DYNAMICS = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / MANOEUVRE_TIME]])


def van_loan(duration):
    """F and Q from one matrix exponential: C. F. Van Loan, IEEE Trans. Automatic Control, 1978."""
    block = np.zeros((6, 6))
    block[:3, :3], block[3:, 3:] = -DYNAMICS, DYNAMICS.T
    block[2, 5] = 2.0 / MANOEUVRE_TIME
    both = expm(block * duration)
    return both[3:, 3:].T, both[3:, 3:].T @ both[:3, 3:]


@pytest.mark.parametrize("duration", [1e-3, 0.1, 1.0, 2.5, 2.6, 12.0])
def test_the_motion_is_that_of_the_matrix_exponential(duration):
    F, Q = van_loan(duration)
    transition, noise = singer_motion(duration)
    # What the exponential and the product after it round, they round of their largest terms.
    rounding = 100.0 * np.finfo(float).eps
    np.testing.assert_allclose(transition, F, rtol=1e-9, atol=rounding * np.abs(F).max())
    largest = np.abs(F).max() * np.abs(np.linalg.solve(F, Q)).max()
    np.testing.assert_allclose(noise, Q, rtol=1e-9, atol=rounding * largest)


@pytest.mark.parametrize("duration", [1e-6, 1e-3])
def test_a_short_time_is_a_driven_triple_integrator(duration):
    """Where the closed form of Q cancels: q dt^5 / 20, q dt^4 / 8, ..."""
    t, q = duration, 2.0 / MANOEUVRE_TIME
    expected = q * np.array(
        [[t**5 / 20, t**4 / 8, t**3 / 6], [t**4 / 8, t**3 / 3, t**2 / 2], [t**3 / 6, t**2 / 2, t]]
    )
    np.testing.assert_allclose(singer_motion(t)[1], expected, rtol=2 * t)


def test_a_lost_target_runs_on_and_then_slows_down():
    assert bridged(MANOEUVRE_TIME) == (MANOEUVRE_TIME, 1.0)
    travelled, left = bridged(1e3)
    assert travelled == pytest.approx(MANOEUVRE_TIME + FADE_TIME)
    assert left == pytest.approx(0.0)
    h = 1e-6
    slope = (bridged(9.0 + h)[0] - bridged(9.0 - h)[0]) / (2 * h)
    assert slope == pytest.approx(bridged(9.0)[1])


KNOWN = 1e-12  # m^2/s^4, next to nothing uncertain
LEADS = np.linspace(0.0, 20.0, 41)


def ahead(state, variance, turn_rate, leads):
    """Positions, velocities and accelerations."""
    motions = [
        TURN(state.ravel(), variance, turn_rate, lead).full().reshape(3, 3) for lead in leads
    ]
    return np.swapaxes(motions, 0, 1)


def test_a_circle_is_predicted_round():
    omega, radius = 0.1, 50.0
    angle = omega * LEADS
    circle = radius * np.array([np.cos(angle), np.sin(angle), 0.0 * angle]).T
    state = np.array([[radius, 0, 0], [0, radius * omega, 0], [-radius * omega**2, 0, 0]])
    positions, velocities, accelerations = ahead(state, KNOWN, omega, LEADS)
    np.testing.assert_allclose(positions, circle, atol=1e-9)
    np.testing.assert_allclose(accelerations, -(omega**2) * circle, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(velocities, axis=1), radius * omega)


@pytest.mark.parametrize("turn_rate", [0.0, -0.0, 1e-9, 0.3, -0.3])
def test_positions_velocities_and_accelerations_are_derivatives(turn_rate):
    state = np.array([[1.0, 2.0, 3.0], [4.0, -3.0, 0.5], [0.6, 0.1, 0.0]])
    leads = np.linspace(0.0, 10.0, 2001)
    motion = ahead(state, 0.01, turn_rate, leads)
    np.testing.assert_allclose(motion[0, 0], state[0], atol=1e-8)
    np.testing.assert_allclose(motion[1, 0], state[1], atol=1e-8)
    for k in (0, 1):
        slope = np.gradient(motion[k], leads, axis=0)[1:-1]
        np.testing.assert_allclose(slope, motion[k + 1, 1:-1], atol=2e-5)


def test_a_straight_run_goes_on():
    state = np.array([[0.0, 0.0, 0.0], [3.0, 4.0, -1.0], [0.0, 0.0, 0.0]])
    positions = ahead(state, KNOWN, 0.0, LEADS)[0]
    np.testing.assert_allclose(positions, np.outer(LEADS, state[1]), atol=1e-4)


def test_a_braking_target_comes_to_rest():
    state = np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [-2.0, 0.0, 0.0]])
    velocities = ahead(state, KNOWN, 0.0, np.linspace(0.0, 100.0, 50))[1]
    assert np.all(velocities[:, 0] > -1e-9)
    assert velocities[-1, 0] == pytest.approx(0.0, abs=1e-6)


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=9, max_size=9),
    st.floats(1e-12, 1e6),
    st.floats(-1e6, 1e6),
)
def test_predictions_are_finite(state, variance, turn_rate):
    motion = ahead(np.reshape(state, (3, 3)), variance, turn_rate, LEADS)
    assert np.all(np.isfinite(motion))
