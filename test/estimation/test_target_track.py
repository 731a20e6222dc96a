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
from scipy.stats import multivariate_normal

from uav_tracking_mpc.estimation.target_track import (
    AGILITIES,
    OUTLIER_VARIANCE,
    OUTLIER_WEIGHT,
    QUIET,
    QUIET_LEAST,
    RATES,
    TURN_SPEED,
    TURNING,
    TargetTrack,
    singer_motion,
)

MODES = range(len(AGILITIES))


class Textbook:
    """Interacting multiple models mode by mode, from the track's own beginning."""

    def __init__(self, track):
        self.probabilities = track.probabilities.copy()
        self.states, self.covariances = track._states.copy(), track._covariances.copy()

    def mixture(self, shares):
        mean = sum(share * state for share, state in zip(shares, self.states, strict=True))
        covariances = np.zeros((3, 3, 3))
        for share, state, own in zip(shares, self.states, self.covariances, strict=True):
            covariances += share * (own + (state - mean) @ (state - mean).T / 3.0)
        return mean, covariances

    def update(self, elapsed, position, variances, velocity=None):
        total = RATES.sum(axis=1)
        changes = RATES / total[:, None] * -np.expm1(-total * elapsed)[:, None]
        changes += np.diag(np.exp(-total * elapsed))
        speed = np.linalg.norm(self.mixture(self.probabilities)[0][1])
        F, Q = singer_motion(elapsed)
        predicted = self.probabilities @ changes
        states, covariances = [], []
        for mode in MODES:
            shares = changes[:, mode] * self.probabilities / predicted[mode]
            if mode == QUIET and self.probabilities[QUIET] > QUIET_LEAST:
                shares = np.eye(len(AGILITIES))[QUIET]
            x, P = self.mixture(shares)
            x, P = F @ x, F @ P @ F.T + AGILITIES[mode] ** 2 * Q
            if mode == TURNING:  # at a moment of the interval, each as likely as the other
                turned = np.array([[elapsed**2 / 3.0, elapsed / 2.0], [elapsed / 2.0, 1.0]])
                P[:, :2, :2] += max(speed, TURN_SPEED) ** 2 * turned
            states.append(x)
            covariances.append(P)
        self.states, self.covariances, self.probabilities = states, covariances, predicted
        self.correct(np.eye(3)[0], position, variances)
        if velocity is not None:
            self.correct(np.eye(3)[1], *velocity)

    def correct(self, H, measured, variances):
        likelihoods = []
        for mode in MODES:
            x, P = self.states[mode], self.covariances[mode]
            innovations, own = measured - H @ x, [H @ P[axis] @ H for axis in range(3)]
            chances = []
            for chance, times in ((1.0, 1.0), (np.exp(OUTLIER_WEIGHT), OUTLIER_VARIANCE)):
                density = multivariate_normal(cov=np.diag(own + times * variances))
                chances.append(chance * density.pdf(innovations))
            likelihoods.append(sum(chances))
            information = (chances[0] + chances[1] / OUTLIER_VARIANCE) / sum(chances) / variances
            for axis in range(3):
                K = P[axis] @ H / (own[axis] + 1.0 / information[axis])
                x[:, axis] += K * innovations[axis]
                P[axis] -= np.outer(K, H @ P[axis])
        self.probabilities = self.probabilities * likelihoods
        self.probabilities /= self.probabilities.sum()


@pytest.mark.parametrize("run", [0.0, 5.0])
@pytest.mark.parametrize("sees_velocity", [False, True])
@pytest.mark.parametrize("deviations", [[1.0, 1.0, 1.0], [3.0, 0.3, 1.0]])
def test_the_textbook_agrees(run, sees_velocity, deviations):
    """A target that stands or turns back half-way, and an outlier now and then."""
    random, time, variances = np.random.default_rng(1), 0.0, np.square(deviations)
    track = TargetTrack(0.0, np.zeros(3), variances, 0.5, 5.0)
    plain = Textbook(track)
    for elapsed in random.uniform(0.05, 0.6, 60):
        time += elapsed
        direction = 1.0 if time < 10.0 else -1.0
        place = np.array([run * min(time, 20.0 - time), -2.0 * time, 0.0])
        position = place + random.choice([1.0, 4.0]) * np.sqrt(variances) * random.standard_normal(
            3
        )
        velocity = None
        if sees_velocity:
            velocity = (
                np.array([run * direction, -2.0, 0.0]) + 0.2 * random.standard_normal(3),
                np.full(3, 0.1),
            )
        assert track.update(time, position, variances, np.inf, velocity)
        plain.update(elapsed, position, variances, velocity)
        np.testing.assert_allclose(track.probabilities, plain.probabilities, atol=1e-9)
        state, covariances = plain.mixture(plain.probabilities)
        np.testing.assert_allclose(track.state, state, rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(track.covariances, covariances, rtol=1e-6, atol=1e-7)


def flown(path, noise, seconds, rate=5.0, seed=0):
    random = np.random.default_rng(seed)
    track = TargetTrack(0.0, path(0.0), np.full(3, noise**2), 0.5, 5.0)
    for time in np.arange(1.0, seconds * rate) / rate:
        track.update(
            time, path(time) + noise * random.standard_normal(3), np.full(3, noise**2), 16.27
        )
    return track


def straight(time):
    return np.array([4.0 * time, 3.0 * time, 0.0])


def test_a_quiet_run_is_averaged_over_tens_of_seconds():
    """Over 100 s the best straight line errs by 2 sigma / sqrt(n) = 0.45 m on each axis."""
    tracks = [flown(straight, 5.0, 100.0, seed=seed) for seed in range(5)]
    last = straight(99.8)
    assert np.std([track.state[0] - last for track in tracks]) < 1.0
    assert np.std([track.state[1] - [4.0, 3.0, 0.0] for track in tracks]) < 0.15
    assert all(track.probabilities[QUIET] > 0.9 for track in tracks)
    assert all(track.agility < 0.1 for track in tracks)


def test_a_turn_on_the_spot_is_followed_at_once():
    def zigzag(time):
        return np.array([5.0 * min(time, 60.0), 5.0 * max(0.0, time - 60.0), 0.0])

    for noise, after, error in ((0.01, 0.4, 0.3), (0.5, 2.0, 1.0)):
        track = flown(zigzag, noise, 60.0 + after + 0.2)
        assert track.time == pytest.approx(60.0 + after)
        np.testing.assert_allclose(track.state[1], [0.0, 5.0, 0.0], atol=error)


def test_the_agility_is_that_of_the_target():
    def weaving(time):
        """Twice its standard deviation of 1 m/s^2 at most, in 6 s."""
        return np.array([5.0 * time, 1.4 * np.sin(time), 0.0])

    assert flown(weaving, 0.1, 60.0).agility > 0.5
    assert flown(straight, 0.1, 60.0).agility < 0.05


def test_the_modes_begin_with_the_agility_that_is_told():
    begun = [
        TargetTrack(0.0, np.zeros(3), np.ones(3), agility, 5.0) for agility in (1e-3, 0.1, 1.0, 1e2)
    ]
    assert np.all(np.diff([track.agility for track in begun]) >= 0.0)
    assert begun[0].probabilities[QUIET] > 0.9
    assert all(track.probabilities[TURNING] < 1e-9 for track in begun)


def test_a_doubted_variance_lets_no_noise_become_speed():
    sure, doubting = (TargetTrack(0.0, np.zeros(3), np.full(3, 0.01), 0.5, 5.0) for _ in range(2))
    position = np.array([3.0, 0.0, 0.0])
    sure.update(0.2, position, np.full(3, 0.01), np.inf)
    doubting.update(0.2, position, np.full(3, 0.01), np.inf, doubted=True)
    assert np.linalg.norm(sure.state[1]) > 10.0
    assert np.linalg.norm(doubting.state[1]) < 3.0


def test_what_no_mode_explains_is_left_out_and_changes_nothing():
    track, other = flown(straight, 1.0, 10.0), flown(straight, 1.0, 10.0)
    assert not track.update(10.0, np.array([1e3, 0.0, 0.0]), np.ones(3), 16.27)
    np.testing.assert_array_equal(track.state, other.state)
    assert track.time == other.time


def test_a_velocity_that_no_mode_explains_is_left_out():
    track, other = flown(straight, 1.0, 10.0), flown(straight, 1.0, 10.0)
    track.update(
        10.0, straight(10.0), np.ones(3), 16.27, (np.array([1e3, 0.0, 0.0]), np.full(3, 0.04))
    )
    other.update(10.0, straight(10.0), np.ones(3), 16.27)
    np.testing.assert_array_equal(track.state, other.state)


@given(
    st.lists(
        st.tuples(st.floats(1e-9, 300.0), st.lists(st.floats(-1e6, 1e6), min_size=3, max_size=3)),
        max_size=40,
    ),
    st.sampled_from([1e-3, 0.1, 3.0, 1e3]),
    st.sampled_from([1e-3, 0.5, 100.0]),
)
def test_the_covariance_stays_positive_definite(steps, noise, agility):
    track, time = TargetTrack(0.0, np.zeros(3), np.full(3, noise**2), agility, 5.0), 0.0
    for elapsed, position in steps:
        time += elapsed
        track.update(time, np.array(position), np.full(3, noise**2), gate=np.inf)
        for covariance in (*track.covariances, *track._covariances.reshape(-1, 3, 3)):
            scale = np.sqrt(np.diag(covariance))
            assert np.all(scale > 0.0)
            assert np.linalg.eigvalsh(covariance / np.outer(scale, scale))[0] > 0.0
        assert np.all(np.isfinite(track.state)) and np.isfinite(track.turn_rate)
        assert track.probabilities.sum() == pytest.approx(1.0)
        assert np.isfinite(track.position_std(track.time + 10.0))
