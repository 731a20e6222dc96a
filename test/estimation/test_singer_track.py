import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from uav_tracking_mpc.estimation.singer_track import (
    BRIDGE_TIME,
    FADE_TIME,
    MANOEUVRE_TIME,
    SingerTrack,
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


def test_a_plain_kalman_filter_agrees():
    """Predict and correct as in the textbook, by its short form (I - K H) P."""
    random, noise, agility = np.random.default_rng(1), 3.0, 0.5
    times = np.cumsum(random.uniform(0.02, 1.0, 60))
    positions = random.normal(0.0, noise, (60, 3)) + np.outer(times, [5.0, -2.0, 0.1])
    track = SingerTrack(times[0], positions[0], noise, agility, 10.0)
    state, covariance = np.zeros((3, 3)), np.diag([noise**2, 100.0, agility**2])
    state[0], H = positions[0], np.array([[1.0, 0.0, 0.0]])
    for before, time, position in zip(times, times[1:], positions[1:], strict=False):
        F, Q = van_loan(time - before)
        state, covariance = F @ state, F @ covariance @ F.T + agility**2 * Q
        K = covariance @ H.T / (H @ covariance @ H.T + noise**2)
        state = state + K @ (position[None] - H @ state)
        covariance = covariance - K @ H @ covariance
        assert track.update(time, position, gate=np.inf)
    np.testing.assert_allclose(track.state, state, rtol=1e-7, atol=1e-7 * np.abs(state).max())
    np.testing.assert_allclose(track.covariance, covariance, rtol=1e-7, atol=1e-10)


def test_a_measured_velocity_is_taken_in_as_the_textbook_says():
    """Position and velocity one after the other are both together: their noise is independent."""
    track = SingerTrack(0.0, np.zeros(3), 3.0, 0.5, 10.0)
    F, Q = van_loan(0.7)
    P = F @ track.covariance @ F.T + 0.25 * Q
    position, velocity = np.array([4.0, -2.0, 1.0]), np.array([5.0, -3.0, 0.5])
    H, R = np.eye(3)[:2], np.diag([9.0, 0.04])
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    assert track.update(0.7, position, np.inf, motion=(velocity, 0.04))
    np.testing.assert_allclose(track.state, K @ np.array([position, velocity]), rtol=1e-9)
    np.testing.assert_allclose(track.covariance, P - K @ H @ P, rtol=1e-9, atol=1e-9)


def test_a_velocity_that_the_track_cannot_explain_is_left_out():
    track, other = (SingerTrack(0.0, np.zeros(3), 3.0, 0.5, 10.0) for _ in range(2))
    track.update(0.7, np.ones(3), 16.0, motion=(np.array([1e3, 0.0, 0.0]), 0.04))
    other.update(0.7, np.ones(3), 16.0)
    np.testing.assert_array_equal(track.state, other.state)


def test_a_lost_target_runs_on_and_then_slows_down():
    assert bridged(BRIDGE_TIME) == (BRIDGE_TIME, 1.0)
    travelled, left = bridged(1e3)
    assert travelled == pytest.approx(BRIDGE_TIME + FADE_TIME)
    assert left == pytest.approx(0.0)
    h = 1e-6
    slope = (bridged(9.0 + h)[0] - bridged(9.0 - h)[0]) / (2 * h)
    assert slope == pytest.approx(bridged(9.0)[1])


@settings(deadline=None)
@given(
    st.lists(
        st.tuples(st.floats(1e-9, 300.0), st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3)),
        max_size=40,
    ),
    st.sampled_from([1e-3, 0.1, 3.0, 1e3]),
    st.sampled_from([1e-3, 0.5, 100.0]),
)
def test_the_covariance_stays_positive_definite(steps, noise, agility):
    track, time = SingerTrack(0.0, np.zeros(3), noise, agility, 10.0), 0.0
    for elapsed, position in steps:
        time += elapsed
        track.update(time, np.array(position), gate=np.inf)
        scale = np.sqrt(np.diag(track.covariance))
        assert np.all(scale > 0.0)
        assert np.linalg.eigvalsh(track.covariance / np.outer(scale, scale))[0] > 0.0
        assert np.all(np.isfinite(track.state)) and np.isfinite(track.turn_rate)
        assert np.isfinite(track.position_std(10.0))
