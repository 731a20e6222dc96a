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

r"""How a target moves, and what is known of one: several models side by side, behind its positions.

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

A step of all modes is one compiled function.

Singer's model is that of R. A. Singer, "Estimating Optimal Tracking Filter Performance for Manned
Maneuvering Targets", IEEE Trans. Aerospace and Electronic Systems 6(4), 1970: on each axis p' = v,
v' = a and

.. math:: a' = -a / \tau + w, \quad E[w(t) w(s)] = (2 \sigma_a^2 / \tau)\, \delta(t - s)

so that the acceleration has standard deviation sigma_a and is forgotten after tau.

A prediction goes on turning: constant turn rate, fading change of speed. With the horizontal
velocity as a complex number, u its direction, omega the turn rate and a_t the acceleration along u,

.. math:: v(t) = u e^{i \omega t} (s + a_t \tau_v (1 - e^{-t/\tau_v}))

which is integrated in closed form. a_t is weighted by how far it exceeds its uncertainty, and never
reverses the target. The vertical velocity is held.

Errors 5 and 10 s ahead, compared with those of a held velocity: on circles a quarter without noise
at 10 Hz, and a few percent less with 3 m of noise at 5 Hz; on noisy straight runs 2 to 6 % more; in
stop and go the same. Those of Singer's own model lie between without noise and are the largest with
it.
"""

from __future__ import annotations

import functools
import itertools
import math
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.symbolic.functions import one_at_a_time
from uav_tracking_mpc.symbolic.layout import Layout
from uav_tracking_mpc.symbolic.native_code import NativeFunction

# s, tau: least prediction errors on circles, straight runs, stop and go; and without a position for
# so long the velocity fades
MANOEUVRE_TIME = 5.0
STRAIGHT_TIME = 30.0  # s, the same of a target that has run straight on
FADE_TIME = 10.0  # s, its time constant
TERMS = 16  # of the series of exp(-x), x <= 1/2: exact to rounding
TURN_RATE_MAX = 1.0  # rad/s
# s, tau_v: vehicles change their speed for a few seconds, over which the turn rate is averaged, too
SPEED_TIME = 2.0
REWIND = 1.0  # s before the newest position for which a track tells where the target was
STRAIGHT = 1e-7  # rad/s: a slower turn cannot be told from a straight line

# The models side by side
QUIET, TURNING = 0, 3  # of the modes: quiet, gentle, hard, turn
AGILITIES = np.array([1e-3, 0.1, 1.0, 1.0])  # m/s^2, sigma_a of each
TURN_SPEED = 5.0  # m/s, least standard deviation on each axis by which a turn changes the velocity
# 1/s: how often the mode of a row changes to that of a column. A turn is over at once.
RATES = np.array(
    [[0.0, 3e-4, 3e-4, 3e-4], [0.05, 0.0, 0.05, 0.02], [0.0, 0.2, 0.0, 0.05], [0.0, 0.0, 1e3, 0.0]]
)
RUNS_STRAIGHT = 0.9  # probability of the quiet mode above which a hidden target runs straight on
QUIET_LEAST = 0.02  # probability of the quiet mode above which it is not mixed with the others
PROBABILITY_MIN = 1e-12  # -, of a mode
OUTLIER_WEIGHT = math.log(0.03)  # -, logarithm of the share of measurements that are outliers
OUTLIER_VARIANCE = 25.0  # -, times as uncertain as the others
SECOND = 4.0  # -, factor on the gate of a track's second position: its velocity is not known yet
ROUNDING = 1e-13  # -, rounding of a variance, before it is corrected
FORGOTTEN = 300.0  # s without a position after which nothing is left of a track
# Velocity [m/s] and its variances on each axis [m^2/s^2], shape (3,) each.
Motion = tuple[NDArray[np.float64], NDArray[np.float64]]

LEVEL = slice(0, 2)  # of the axes
COUNT, AXES = len(AGILITIES), range(3)
# Of each mode (p, v, a), each of three axes, and the covariance of (p, v, a) on each axis; and the
# same of the mixture of all of them.
TRACK = Layout(
    states=9 * COUNT, covariances=27 * COUNT, probabilities=COUNT, state=9, covariance=27
)  # fmt: skip
# Which derivative of the position is measured, as a row of (p, v, a); the measurement and its
# variances, the gate, whether they are doubted; F and Q of the time since the one before, and F of
# the states, whose velocity may fade.
SEEN = Layout(
    elapsed=1, row=3, measured=3, variances=3, gate=1, doubted=1, transition=9, noise=9, carried=9
)


# 1/s: of p' = v, v' = a, a' = -a / tau, beside what drives them: the exponential of both times t
# holds F and Q (C. F. Van Loan, IEEE Trans. Automatic Control 23(3), 1978). Coefficients of its
# series in t: unlike the closed form, they cancel to nothing for no short time.
_SINGER = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0 / MANOEUVRE_TIME]])
_DRIVEN = np.block(
    [[-_SINGER, np.diag([0.0, 0.0, 2.0 / MANOEUVRE_TIME])], [np.zeros((3, 3)), _SINGER.T]]
)
_SERIES = np.stack(
    [np.linalg.matrix_power(_DRIVEN, k) / math.factorial(k) for k in range(TERMS)], axis=-1
)


def singer_motion(duration: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Transition matrix and covariance of the noise of unit sigma_a.

    Args:
        duration: At least 0, in [s].

    Returns:
        F and Q, shape (3, 3) each.
    """
    if duration > 0.5 * MANOEUVRE_TIME:
        half, noise = singer_motion(duration / 2.0)
        return half @ half, half @ noise @ half.T + noise
    exponential = _SERIES @ duration ** np.arange(TERMS)
    transition = exponential[3:, 3:].T
    return transition, transition @ exponential[:3, 3:]


def bridged(age: float, held: float = MANOEUVRE_TIME) -> tuple[float, float]:
    """Time travelled at the velocity last known, and the share of it that is left.

    A target that is lost is taken to run on for a while and then to slow down, so that no
    position runs away.

    Args:
        age: Of the newest measurement in [s].
        held: Time for which it is taken to run on in [s].

    Returns:
        Time in [s], and the share, from 0 to 1.
    """
    left = math.exp(-max(age - held, 0.0) / FADE_TIME)
    return min(age, held) + FADE_TIME * (1.0 - left), left


def _turn() -> ca.Function:
    """Position, velocity and acceleration a time ahead of now, shape (9,).

    Of position, velocity, acceleration now, shape (9,), the variance of the acceleration on each
    axis [m^2/s^4], omega [rad/s] and the time [s].
    """
    motion, variance = ca.SX.sym("motion", 9), ca.SX.sym("variance")
    turn_rate, lead = ca.SX.sym("turn_rate"), ca.SX.sym("lead")
    position, velocity, acceleration = motion[:3], motion[3:6], motion[6:]
    speed = ca.sqrt(velocity[0] ** 2 + velocity[1] ** 2)
    u_x = ca.if_else(speed > 0.0, velocity[0] / speed, 1.0)
    u_y = ca.if_else(speed > 0.0, velocity[1] / speed, 0.0)
    rate = ca.fmin(ca.fmax(turn_rate, -TURN_RATE_MAX), TURN_RATE_MAX)
    rate = ca.if_else(rate < 0.0, ca.fmin(rate, -STRAIGHT), ca.fmax(rate, STRAIGHT))
    along = acceleration[0] * u_x + acceleration[1] * u_y
    along *= along * along / (along * along + variance)
    # Speed gained after a long time; braking ends at rest.
    gained = ca.fmax(along * SPEED_TIME, -speed)
    # v = u (lasting e^(turn t) - gained e^(fade t)), turn = i omega and fade = i omega - 1 / tau_v.
    lasting, decay = speed + gained, ca.exp(-lead / SPEED_TIME)
    cosine, sine = ca.cos(rate * lead), ca.sin(rate * lead)
    # Its integral along u and across it; that of the second term is over fade.
    real, imaginary = decay * cosine - 1.0, decay * sine
    size = rate**2 + 1.0 / SPEED_TIME**2
    ahead = lasting * sine / rate - gained * (rate * imaginary - real / SPEED_TIME) / size
    left = lasting * (1.0 - cosine) / rate + gained * (rate * real + imaginary / SPEED_TIME) / size
    level = u_x * ahead - u_y * left, u_y * ahead + u_x * left
    position += ca.vertcat(*level, velocity[2] * lead)
    velocity = ca.jacobian(position, lead)
    after = ca.vertcat(position, velocity, ca.jacobian(velocity, lead))
    return ca.Function("turn", [motion, variance, turn_rate, lead], [ca.densify(after)])


TURN = _turn()


class TargetTrack:
    """A target that has been seen at least once.

    Args:
        time: When it was first seen in [s].
        position: Where, shape (3,), in [m].
        variances: Of that position on each axis, shape (3,), in [m^2].
        agility: Standard deviation of the acceleration with which the modes begin in [m/s^2].
        speed: Standard deviation of the velocity before it is known in [m/s].
        motion: See :meth:`update`.
        gate: Likewise.

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
        motion: Motion | None = None,
        gate: float = math.inf,
    ) -> None:
        self.time, self.count = time, 1
        self.turn_rate = 0.0
        self._memory = np.zeros(TRACK.size)
        known = TRACK.parts(self._memory)
        self._states = known.states.reshape(COUNT, 3, 3)
        self._covariances = known.covariances.reshape(COUNT, 3, 3, 3)
        self.state, self.covariances = known.state.reshape(3, 3), known.covariance.reshape(3, 3, 3)
        self.probabilities = known.probabilities
        self._states[:, 0] = self.state[0] = position
        self._covariances[..., 0, 0] = variances
        self._covariances[..., 1, 1] = speed**2
        self._covariances[..., 2, 2] = AGILITIES[:, np.newaxis] ** 2
        # The modes whose agility is nearest, by its logarithm; none begins with a turn.
        nearness = -0.5 * np.log(AGILITIES / agility) ** 2
        nearness[TURNING] = -math.inf
        weights = np.maximum(np.exp(nearness - nearness.max()), PROBABILITY_MIN)
        self.probabilities[:] = weights / weights.sum()
        self.covariances[:] = np.tensordot(self.probabilities, self._covariances, 1)
        self._step = NativeFunction(track_step(), [self._memory])
        if motion is not None:
            self.see(1, *motion, gate)

    @property
    def agility(self) -> float:
        """Standard deviation of the target's acceleration, over the modes, in [m/s^2]."""
        return math.sqrt(float(self.probabilities @ AGILITIES**2))

    def bridge(self, age: float) -> tuple[float, float]:
        """See :func:`bridged`: it runs on for longer where it has run straight on.

        Args:
            age: Of the track in [s].
        """
        straight = self.probabilities[QUIET] > RUNS_STRAIGHT
        return bridged(age, STRAIGHT_TIME if straight else MANOEUVRE_TIME)

    def variance(self, order: int) -> float:
        """Variance of a derivative of the position, mean of the level axes, in SI units.

        Args:
            order: Of the derivative, 0 to 2.
        """
        east, north, _ = self.covariances[:, order, order].tolist()
        return 0.5 * (east + north)  # type: ignore[no-any-return]

    def position_std(self, time: float) -> float:
        """Standard deviation of the position on the worse level axis in [m].

        Args:
            time: When, in [s]; before the newest position that of the newest one stands in.
        """
        transition, noise = singer_motion(min(max(time - self.time, 0.0), FORGOTTEN))
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
        if not self.see(0, position, variances, gate, elapsed, doubted):
            return False
        self.time, self.count = time, self.count + 1
        if motion is not None:
            self.see(1, *motion, gate)
        (_, (vx, vy, _), (ax, ay, _)) = self.state.tolist()
        # A velocity within its own uncertainty has no direction to turn.
        square = max(vx * vx + vy * vy, 9.0 * self.variance(1))
        share = 1.0 - math.exp(-elapsed / SPEED_TIME)
        self.turn_rate += share * ((vx * ay - vy * ax) / square - self.turn_rate)
        return True

    def see(
        self,
        order: int,
        measured: NDArray[np.float64],
        variances: NDArray[np.float64],
        gate: float,
        elapsed: float = 0.0,
        doubted: bool = False,
    ) -> bool:
        """Whether a measured derivative of the position is taken in: else nothing changes.

        Args:
            order: Of the derivative, 0 or 1.
            measured: Shape (3,), in [m] or [m/s].
            variances: Of it on each axis, shape (3,), in its unit squared.
            gate: See :meth:`update`.
            elapsed: Since the track's time in [s].
            doubted: See :meth:`update`.
        """
        transition, noise = singer_motion(elapsed)
        travelled, left = self.bridge(elapsed)
        carried = singer_motion(travelled)[0] * [[1.0], [left], [left]]
        self._step.arguments[1][:] = [  # in the order of SEEN
            elapsed, *np.eye(3)[order], *measured, *variances, gate, doubted,
            *transition.ravel(), *noise.ravel(), *carried.ravel(),
        ]  # fmt: skip
        self._step.evaluate()
        after, taken = self._step.results
        if taken[0]:
            self._memory[:] = after
        return bool(taken[0])


@functools.cache
@one_at_a_time
def track_step() -> ca.Function:
    """The track after a measurement, and whether that is within the gate."""
    memory, known = TRACK.symbol("track")
    told, seen = SEEN.symbol("seen")
    probabilities, states, covariances = _predicted(known, seen)
    row, variances = seen.row, seen.variances
    innovations = [seen.measured - state @ row for state in states]
    explained = [
        ca.sum1(innovation**2 / (_along(axes, row) + variances))
        for innovation, axes in zip(innovations, covariances, strict=True)
    ]
    taken = ca.mmin(ca.vertcat(*explained)) <= seen.gate
    variances = ca.fmax(variances, seen.doubted * ca.sumsqr(innovations[QUIET]) / 3.0)
    for axes in covariances:
        for axis, each in enumerate(axes):
            each[0, 0] = ca.fmax(each[0, 0], seen.doubted * variances[axis])

    # Kalman corrections
    likelihoods, after, corrected = [], [], []
    for state, axes, innovation in zip(states, covariances, innovations, strict=True):
        own = _along(axes, row)
        total, wide, error = own + variances, own + OUTLIER_VARIANCE * variances, innovation**2
        usual = -0.5 * ca.sum1(ca.log(total) + error / total)
        unusual = OUTLIER_WEIGHT - 0.5 * ca.sum1(ca.log(wide) + error / wide)
        likelihoods.append(ca.logsumexp(ca.vertcat(usual, unusual)))
        # The information of a measurement that may be an outlier is the mean of both.
        outlier = ca.exp(unusual - likelihoods[-1])
        noise = variances / (1.0 - outlier * (1.0 - 1.0 / OUTLIER_VARIANCE))
        gains = [axes[k] @ row / (own[k] + noise[k]) for k in AXES]
        after.append(state + ca.horzcat(*[gains[k] * innovation[k] for k in AXES]).T)
        corrected.append([_joseph(axes[k], gains[k], noise[k], row) for k in AXES])
    logarithms = ca.log(probabilities) + ca.vertcat(*likelihoods)
    weights = ca.fmax(ca.exp(logarithms - ca.mmax(logarithms)), PROBABILITY_MIN)
    probabilities = weights / ca.sum1(weights)
    (state,), (covariance,) = _mixtures(probabilities.T, after, corrected, after[QUIET])
    whole = [*after, *itertools.chain(*corrected), probabilities, state, *covariance]
    whole = ca.densify(ca.vertcat(*[ca.vec(each) for each in whole]))
    return ca.Function("target_track", [memory, told], [whole, taken], {"cse": True})


def _predicted(
    known: SimpleNamespace, seen: SimpleNamespace
) -> tuple[ca.SX, list[Any], list[list[Any]]]:
    """Probabilities, states and covariances of the modes after a time, before a correction.

    A state has a row an axis, here and below.
    """
    transition, noise, carried = (
        ca.reshape(each, 3, 3).T for each in (seen.transition, seen.noise, seen.carried)
    )
    leaving = -ca.expm1(-seen.elapsed * RATES.sum(axis=1)) * known.probabilities
    changes = ca.diag(known.probabilities)
    changes += ca.diag(leaving) @ (RATES / RATES.sum(axis=1, keepdims=True) - np.eye(COUNT))
    probabilities = ca.sum1(changes).T
    shares = (changes @ ca.diag(1.0 / probabilities)).T  # in what each mode begins as
    alone = known.probabilities[QUIET] > QUIET_LEAST
    shares[QUIET, :] = ca.if_else(alone, np.eye(COUNT)[[QUIET]], shares[QUIET, :])
    begun = [ca.reshape(each, 3, 3) for each in ca.vertsplit(known.states, 9)]
    squares = [ca.reshape(each, 3, 3) for each in ca.vertsplit(known.covariances, 9)]
    axes_of = [squares[3 * mode : 3 * mode + 3] for mode in range(COUNT)]
    states, covariances = _mixtures(shares, begun, axes_of, known.state)
    # Singer's motion; a turn changes the velocity at a moment of the interval that is not known.
    t = seen.elapsed
    square = (t > 0.0) * ca.fmax(TURN_SPEED**2, ca.sumsqr(known.state[3:6]))
    turn = square * ca.blockcat([[t**2 / 3.0, t / 2.0, 0.0], [t / 2.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    spreads = [agility**2 * noise for agility in AGILITIES.tolist()]
    spreads[TURNING] += turn
    covariances = [
        [transition @ each @ transition.T + spread for each in axes]
        for axes, spread in zip(covariances, spreads, strict=True)
    ]
    return probabilities, [state @ carried.T for state in states], covariances


def _along(axes: list[ca.SX], row: ca.SX) -> ca.SX:
    """Variances of what a row selects, shape (3,)."""
    return ca.vertcat(*[row.T @ each @ row for each in axes])


def _joseph(covariance: ca.SX, gain: ca.SX, noise: ca.SX, row: ca.SX) -> ca.SX:
    """Joseph's form, and what was rounded off where a correction takes nearly all away."""
    remaining = ca.SX.eye(3) - gain @ row.T
    after = remaining @ covariance @ remaining.T + noise * (gain @ gain.T)
    after += ROUNDING * ca.diag(ca.diag(covariance))
    return 0.5 * (after + after.T)


def _mixtures(
    shares: ca.SX, states: list[Any], covariances: list[list[Any]], origin: ca.SX
) -> tuple[list[Any], list[list[Any]]]:
    """Mean and covariances of mixtures; by how far the modes are apart, averaged over the axes.

    Args:
        shares: Of each mode in each mixture, shape (n, 4).
        states: Of the modes, a row an axis.
        covariances: Of the modes and axes.
        origin: A state near them, of which they differ by little.
    """
    beside = [state - ca.reshape(origin, 3, 3) for state in states]
    means, mixed = [], []
    for row in ca.vertsplit(shares):
        weights = ca.horzsplit(row)
        mean = sum(weight * each for weight, each in zip(weights, beside, strict=True))
        apart = [each - mean for each in beside]
        spread = sum(w * (each.T @ each) for w, each in zip(weights, apart, strict=True)) / 3.0
        means.append(mean + ca.reshape(origin, 3, 3))
        mixed.append(
            [
                sum(w * axes[axis] for w, axes in zip(weights, covariances, strict=True)) + spread
                for axis in AXES
            ]
        )
    return means, mixed
