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

r"""Position, velocity and acceleration of one target by several models side by side.

H. A. P. Blom, Y. Bar-Shalom, "The Interacting Multiple Model Algorithm for Systems with Markovian
Switching Coefficients", IEEE Trans. Automatic Control 33(8), 1988. Kalman filters on Singer's model
run in parallel, a mode each. They differ in how hard the target accelerates, from hardly at all,
which averages over tens of seconds, to a turn on the spot. How well each one predicts what is
measured says which of them holds, with mu_i the probability of mode i and pi_ij that of a change
from i to j:

.. math:: \mu_j \leftarrow N(\nu_j; 0, S_j) \sum_i \pi_{ij} \mu_i

Where an innovation is large, the measurement may be an outlier: its likelihood is that of a mixture
of two normal distributions, and its information the mean of theirs.

One more thing differs from the publication. There each mode starts from a mixture of all of them,
and what little the quiet mode takes over from the others each time would end its memory after a few
seconds. Here the quiet mode goes on alone while its probability is above :data:`QUIET_LEAST`, and
starts anew from the mixture below.

Each axis has a noise and covariances of its own; what the axes have in common, as how far the modes
are apart, counts on each of them alike.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.target_motion import (
    BRIDGE_TIME,
    STRAIGHT_TIME,
    bridged,
    singer_motion,
)

QUIET, TURN = 0, 3  # of the modes: quiet, gentle, hard, turn
AGILITIES = np.array([1e-3, 0.1, 1.0, 1.0])  # m/s^2, sigma_a of each
TURN_SPEED = 5.0  # m/s, least standard deviation on each axis by which a turn changes the velocity
# 1/s: how often the mode of a row changes to that of a column. A turn is over at once.
RATES = np.array(
    [[0.0, 3e-4, 3e-4, 3e-4], [0.05, 0.0, 0.05, 0.02], [0.0, 0.2, 0.0, 0.05], [0.0, 0.0, 1e3, 0.0]]
)
STRAIGHT = 0.9  # probability of the quiet mode above which a target that hides runs straight on
QUIET_LEAST = 0.02  # probability of the quiet mode above which it is not mixed with the others
PROBABILITY_MIN = 1e-12  # -, of a mode
OUTLIER_WEIGHT = math.log(0.03)  # -, logarithm of the share of measurements that are outliers
OUTLIER_VARIANCE = 25.0  # -, times as uncertain as the others
SECOND = 4.0  # -, factor on the gate of a track's second position: its velocity is not known yet
ROUNDING = 1e-13  # -, rounding of a variance, before it is corrected
TURN_MEMORY = 2.0  # s over which the turn rate is averaged
# Velocity [m/s] and its variances on each axis [m^2/s^2], shape (3,) each.
Motion = tuple[NDArray[np.float64], NDArray[np.float64]]

_LEAVING = -RATES.sum(axis=1)
_CHANGES = RATES / RATES.sum(axis=1, keepdims=True) - np.eye(len(RATES))
_SQUARES = AGILITIES[:, np.newaxis, np.newaxis, np.newaxis] ** 2  # m^2/s^4
_TURN_POWERS = np.array([[2.0, 1.0], [1.0, 0.0]])  # -, of the time, in the entries of Q
_TURN_SHARES = np.array([[1.0 / 3.0, 0.5], [0.5, 1.0]])  # -, likewise
_IDENTITY = np.eye(3)  # -
_SELECT = np.eye(2, 3)[:, np.newaxis, :]  # H of the position and of the velocity
LEVEL = slice(0, 2)  # of the axes


class TargetTrack:
    """A target that has been seen at least once.

    Args:
        time: When it was first seen in [s].
        position: Where, shape (3,), in [m].
        variances: Of that position on each axis, shape (3,), in [m^2].
        agility: Standard deviation of the acceleration with which the modes begin in [m/s^2].
        speed: Standard deviation of the velocity before it is known in [m/s].

    Attributes:
        time: Of the newest position taken in, in [s].
        count: How many positions have been taken in.
        state: Position, velocity and acceleration at that time, rows of shape (3, 3).
        covariances: Of (p, v, a) on each axis at that time, shape (3, 3, 3).
        turn_rate: Of the horizontal velocity, averaged over a few seconds, in [rad/s].
        probabilities: Of the modes, shape (4,), [-].
    """

    def __init__(
        self,
        time: float,
        position: NDArray[np.float64],
        variances: NDArray[np.float64],
        agility: float,
        speed: float,
    ) -> None:
        count = len(AGILITIES)
        self.time, self.count = time, 1
        self.turn_rate = 0.0
        self._states = np.zeros((count, 3, 3))
        self._states[:, 0] = position
        self._covariances = np.zeros((count, 3, 3, 3))
        self._covariances[..., 0, 0] = variances
        self._covariances[..., 1, 1] = speed**2
        self._covariances[..., 2, 2] = AGILITIES[:, np.newaxis] ** 2
        # The modes whose agility is nearest, by its logarithm; none begins with a turn.
        nearness = -0.5 * np.log(AGILITIES / agility) ** 2
        nearness[TURN] = -math.inf
        self._weigh(nearness)

    @property
    def agility(self) -> float:
        """Standard deviation of the target's acceleration, over the modes, in [m/s^2]."""
        return math.sqrt(float(self.probabilities @ AGILITIES**2))

    @property
    def held(self) -> float:
        """For how long it is taken to run on without being seen in [s]."""
        return STRAIGHT_TIME if self.probabilities[QUIET] > STRAIGHT else BRIDGE_TIME

    def variance(self, order: int) -> float:
        """Variance of a derivative of the position, mean of the level axes, in SI units.

        Args:
            order: Of the derivative, 0 to 2.
        """
        east, north, _ = self.covariances[:, order, order].tolist()
        return 0.5 * (east + north)  # type: ignore[no-any-return]

    def position_std(self, age: float) -> float:
        """Standard deviation of the position on the worse level axis in [m].

        Args:
            age: Of the track, at least 0, in [s].
        """
        transition, noise = singer_motion(age)
        row = transition[0]
        worse = float((self.covariances[LEVEL] @ row @ row).max())
        return math.sqrt(worse + self.agility**2 * noise[0, 0])

    def update(
        self,
        time: float,
        position: NDArray[np.float64],
        variances: NDArray[np.float64],
        gate: float,
        motion: Motion | None = None,
        doubted: bool = False,
    ) -> bool:
        """Take in a position unless its squared normalised innovation exceeds the gate.

        Args:
            time: When it was measured, after that of the track, in [s].
            position: Shape (3,), in [m].
            variances: Of the position on each axis, shape (3,), in [m^2].
            gate: Greatest squared normalised innovation of the mode that explains it best,
                chi-square of 3 degrees of freedom, [-]; wider for the second position of a track.
            motion: Velocity and its variances, or None; it is left out by itself where it exceeds
                the gate.
            doubted: Whether the variances are little more than a guess: the innovation then counts
                as noise of this position and of the one before, not as motion.
        """
        elapsed, gate = time - self.time, gate * (SECOND if self.count == 1 else 1.0)
        predicted, states, covariances = self._predicted(elapsed)
        innovations = position - states[:, 0]
        squares = innovations * innovations
        if not ((squares / (covariances[..., 0, 0] + variances)).sum(axis=1) <= gate).any():
            return False
        if doubted:
            variances = np.maximum(variances, squares[QUIET].mean())
            covariances[..., 0, 0] = np.maximum(covariances[..., 0, 0], variances)
        self._states, self._covariances = states, covariances
        self._weigh(np.log(predicted) + self._correct(0, innovations, variances))
        self.time, self.count = time, self.count + 1
        if motion is not None:
            self.see_velocity(*motion, gate)
        self._average_turn(elapsed)
        return True

    def see_velocity(
        self, velocity: NDArray[np.float64], variances: NDArray[np.float64], gate: float
    ) -> None:
        """Take in a velocity of the track's time unless its innovation exceeds the gate.

        Args:
            velocity: Shape (3,), in [m/s].
            variances: On each axis, shape (3,), in [m^2/s^2].
            gate: Greatest squared normalised innovation of the mode that explains it best, [-].
        """
        innovations = velocity - self._states[:, 1]
        expected = self._covariances[..., 1, 1] + variances
        if ((innovations * innovations / expected).sum(axis=1) <= gate).any():
            likelihoods = self._correct(1, innovations, variances)
            self._weigh(np.log(self.probabilities) + likelihoods)

    def _predicted(
        self, elapsed: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Probability, state and covariance of each mode after a time, before it is corrected."""
        leaving = np.array([-math.expm1(rate * elapsed) for rate in _LEAVING.tolist()])
        changes = _CHANGES * (leaving * self.probabilities)[:, np.newaxis]
        changes.ravel()[:: len(leaving) + 1] += self.probabilities
        predicted = changes.sum(axis=0)
        shares = (changes / predicted).T
        if self.probabilities[QUIET] > QUIET_LEAST:
            shares[QUIET], shares[QUIET, QUIET] = 0.0, 1.0
        states, covariances = _mixtures(shares, self._states - self.state, self._covariances)
        states += self.state

        transition, noise = singer_motion(elapsed)
        covariances = transition @ covariances @ transition.T + _SQUARES * noise
        # The velocity becomes another one at a moment of the interval that is not known.
        (vx, vy, vz) = self.state[1].tolist()
        square = max(TURN_SPEED**2, vx * vx + vy * vy + vz * vz)
        covariances[TURN, :, :2, :2] += square * _TURN_SHARES * elapsed**_TURN_POWERS
        if elapsed <= self.held:
            return predicted, transition @ states, covariances
        travelled, left = bridged(elapsed, self.held)
        states = singer_motion(travelled)[0] @ states
        states[:, 1:] *= left
        return predicted, states, covariances

    def _correct(
        self, order: int, innovations: NDArray[np.float64], variances: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Kalman correction by a measured derivative of order 0 or 1; log-likelihoods."""
        covariances, squares = self._covariances, innovations * innovations
        own = covariances[..., order, order]
        total, wide = own + variances, own + OUTLIER_VARIANCE * variances
        usual = -0.5 * (np.log(total) + squares / total).sum(axis=1)
        unusual = OUTLIER_WEIGHT - 0.5 * (np.log(wide) + squares / wide).sum(axis=1)
        likelihoods = np.logaddexp(usual, unusual)
        # The information of a measurement that may be an outlier is the mean of both.
        outlier = np.exp(unusual - likelihoods)[:, np.newaxis]
        noise = variances / (1.0 - outlier * (1.0 - 1.0 / OUTLIER_VARIANCE))
        gains = covariances[..., order] / (own + noise)[..., np.newaxis]
        columns = gains[..., np.newaxis]
        self._states = self._states + gains.swapaxes(1, 2) * innovations[:, np.newaxis, :]
        # Joseph's form, and what was rounded off where a correction takes nearly all away.
        remaining = _IDENTITY - columns * _SELECT[order]
        corrected = remaining @ covariances @ remaining.swapaxes(2, 3)
        corrected += noise[..., np.newaxis, np.newaxis] * columns * gains[..., np.newaxis, :]
        corrected += ROUNDING * _IDENTITY * covariances
        self._covariances = 0.5 * (corrected + corrected.swapaxes(2, 3))
        return likelihoods

    def _weigh(self, logarithms: NDArray[np.float64]) -> None:
        """Probabilities from their logarithms, up to a common term; the mixture of all modes."""
        weights = np.maximum(np.exp(logarithms - logarithms.max()), PROBABILITY_MIN)
        self.probabilities = weights / weights.sum()
        origin = self._states[QUIET]
        shares = self.probabilities[np.newaxis]
        states, covariances = _mixtures(shares, self._states - origin, self._covariances)
        self.state, self.covariances = states[0] + origin, covariances[0]

    def _average_turn(self, elapsed: float) -> None:
        (_, (vx, vy, _), (ax, ay, _)) = self.state.tolist()
        # A velocity within its own uncertainty has no direction to turn.
        square = max(vx * vx + vy * vy, 9.0 * self.variance(1))
        share = 1.0 - math.exp(-elapsed / TURN_MEMORY)
        self.turn_rate += share * ((vx * ay - vy * ax) / square - self.turn_rate)


def _mixtures(
    shares: NDArray[np.float64], states: NDArray[np.float64], covariances: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and covariances of mixtures; by how far the modes are apart, averaged over the axes.

    Args:
        shares: Of each mode in each mixture, shape (n, 4).
        states: Of the modes, shape (4, 3, 3).
        covariances: Of the modes on each axis, shape (4, 3, 3, 3).
    """
    count = len(shares)
    means = (shares @ states.reshape(-1, 9)).reshape(count, 3, 3)
    # sum_i w_i (x_i - m) (x_i - m)' as one product: the columns are modes and axes.
    apart = (states - means[:, np.newaxis]) * np.sqrt(shares / 3.0)[:, :, np.newaxis, np.newaxis]
    apart = apart.transpose(0, 2, 1, 3).reshape(count, 3, -1)
    spread = (shares @ covariances.reshape(-1, 27)).reshape(count, 3, 3, 3)
    return means, spread + (apart @ apart.swapaxes(1, 2))[:, np.newaxis]
