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

r"""Mean wind, gusts and sensor biases, from positions, ground velocities and air velocities.

A Kalman filter. With a the air velocity as heading, path angle and airspeed tell it,
:math:`\alpha` the share by which the airspeed reads too much, :math:`\beta` the angle by which the
heading reads too far to the left, w the mean wind, g the gust and b the bias of the ground
velocity,

.. math::

    p' = a - \alpha a - \beta\, e_z \times a + w + g,\qquad
    p_{measured} = p,\qquad v_{measured} = p' + b.

The mean wind has a level trend t, :math:`w' = t`, that is forgotten slowly: a wind that turns is
followed without a lag. In a direction in which a is a guess, both the velocity and the way that was
flown are as uncertain as the guess.

Gusts are coloured noise, :math:`g' = -g / T + n`, with the correlation time T = L / V of the
Dryden spectra (:mod:`~uav_tracking_mpc.dynamics.air`; the longitudinal form on all axes).
Everything else wanders slowly. How strong the gusts are is seen, and so is how noisy positions and
velocities are, which until then counts as their source tells it. A bias of the ground velocity
shows at once beside the positions, those of heading and airspeed while the aircraft turns, for they
turn with it and the wind does not. While it rolls into a turn or out of it a real aircraft slips:
its heading is then off by degrees, and alpha and beta are considered (Schmidt 1966) but not
estimated. A ground velocity that is far from all of this and from the way flown is left out
(:mod:`~uav_tracking_mpc.estimation.velocity_check`).
"""

from __future__ import annotations

import functools
import math

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.air import gust_scales
from uav_tracking_mpc.estimation.noise_meter import MEMORY, NoiseMeters, Signal
from uav_tracking_mpc.estimation.sensor_health import JUMPED, OFF, STUCK, USED
from uav_tracking_mpc.estimation.told_noise import UNKNOWN
from uav_tracking_mpc.estimation.velocity_check import Velocity, VelocityCheck
from uav_tracking_mpc.symbolic.functions import BufferedFunction

# Standard deviations before anything is measured
WIND, GUST, GROUND_BIAS = 10.0, 2.5, 2.0  # m/s
AIRSPEED_SHARE, HEADING_BIAS = 0.02, 0.02  # -, rad
# How much what is constant may wander, in its unit per root of s
WIND_WALK, GROUND_WALK, SHARE_WALK, HEADING_WALK = 0.03, 0.01, 2e-4, 2e-4
POSITION_NOISE, VELOCITY_NOISE = 0.1, 0.05  # m, m/s: least standard deviations believed
GUST_WALK = 1.0  # m^2/s^3, that of moderate gusts, until it is seen how strong they are
TREND, TREND_TIME = 0.03, 60.0  # m/s^2, s: deviation of the wind's change, how long it lasts
# Over which the air velocity is averaged that multiplies alpha and beta. A gust changes the
# airspeed of a real aircraft, and its heading as it weathercocks, before it moves the aircraft:
# v_measured - a then changes exactly as -a does, and the gust would be taken for alpha.
AVERAGING_TIME = 5.0  # s
# Positions that are elsewhere by more than this and so many standard deviations of their noise are
# left out for a time. If they stay there, that is where the aircraft is; what is told of its place
# goes there by and by.
JUMP, DEVIATIONS, JUMP_TIME, FADE_TIME = 2.0, 6.0, 2.0, 10.0  # m, -, s, s
STEADY_SHARE = 0.1  # of the airspeed, that the air velocity may be apart from its average
LONGEST_GAP = 2.0  # s without a measurement, after which the position begins anew

P, W, G, B = (slice(3 * k, 3 * k + 3) for k in range(4))
T, ALPHA, BETA, SIZE = slice(12, 14), 14, 15, 16


class WindFilter:
    """The filter of the module's docstring; its state is (p, w, g, b, t, alpha, beta).

    Attributes:
        place: Whether positions are used, or why not: as of
            :class:`~uav_tracking_mpc.estimation.sensor_health.SensorHealth`.
        velocity: Likewise of the ground velocity.
    """

    def __init__(self) -> None:
        self._meters, self._check = _meters(), VelocityCheck()
        # The upper triangle of the covariance, by columns.
        self._state, self._covariance = np.zeros(SIZE), np.zeros(SIZE * (SIZE + 1) // 2)
        self._air, self._air_before = np.zeros(3), np.zeros(3)
        self._steady_air, self._times = np.zeros(3), np.ones(3)
        self._scalars = np.zeros(2)  # elapsed time [s], turn rate [rad/s]
        # Position, ground velocity, what is told of their noise, and the guess of the air velocity.
        self._measured = np.zeros(15)
        air = self._air_before, self._air, self._steady_air
        meters = self._meters.state, self._meters.compared
        self._update = BufferedFunction(
            _function(),
            [
                self._scalars, *air, self._times, self._state, self._covariance, *meters,
                self._measured,
            ],
        )  # fmt: skip
        self.reset()

    def reset(self) -> None:
        """Forget air and biases."""
        self._meters.reset()
        self._check.reset()
        self._time: float | None = None
        self._jumped = 0.0  # s, for which positions have been elsewhere
        self._faded = np.zeros(3)  # m, of the last jump
        self._last = np.full(3, np.nan)  # position as measured last
        self.place = self.velocity = USED
        self._judged_at, self._velocity = math.nan, Velocity.EXPECTED
        self._state[:] = 0.0
        deviations = [POSITION_NOISE, WIND, GUST, GROUND_BIAS]
        prior = [*np.repeat(deviations, 3), 0.2 * TREND, 0.2 * TREND, AIRSPEED_SHARE, HEADING_BIAS]
        self._covariance[:] = 0.0
        self._covariance[_DIAGONAL] = np.square(prior)
        self._air[:] = self._steady_air[:] = 0.0
        self._scalars[:] = 0.0
        self._times[:] = 1.0

    def begin_as(self, other: WindFilter) -> None:
        """Know what another filter knows of the air and of the sensors.

        Args:
            other: That goes on.
        """
        self.reset()
        self._state[:], self._covariance[:] = other._state, other._covariance
        self._meters.state[:], self._times[:] = other._meters.state, other._times
        self._time, self._air[:], self._faded[:] = other._time, other._air, other._faded
        self._measured[:], self._last[:] = other._measured, other._last
        self._steady_air[:], self._scalars[:] = other._steady_air, other._scalars

    def share_noise(self, other: WindFilter) -> None:
        """Take noise and gusts to be as strong as another filter has found them.

        Args:
            other: That measures more.
        """
        self._meters.state[:] = other._meters.state

    @property
    def position(self) -> NDArray[np.float64]:
        """P at the newest measurement, shape (3,), in [m]; after a jump it gets there gently."""
        return np.asarray(self._state[P] + self._faded)

    @property
    def mean_wind(self) -> NDArray[np.float64]:
        """w, shape (3,), in [m/s]."""
        return self._state[W].copy()

    @property
    def trend(self) -> NDArray[np.float64]:
        """w', shape (3,), in [m/s^2]; level."""
        return np.array([*self._state[T], 0.0])

    @property
    def wind_deviation(self) -> float:
        """Standard deviation of the level part of w, on the worse axis, in [m/s]."""
        return math.sqrt(max(self._covariance[_DIAGONAL[W]][:2].max(), 0.0))

    @property
    def gust(self) -> NDArray[np.float64]:
        """G at the newest measurement, shape (3,), in [m/s]."""
        return self._state[G].copy()

    @property
    def correlation_times(self) -> NDArray[np.float64]:
        """How long gusts last on each axis, shape (3,), in [s]."""
        return self._times.copy()

    @property
    def ground_velocity_bias(self) -> NDArray[np.float64]:
        """b, shape (3,), in [m/s]."""
        return self._state[B].copy()

    @property
    def airspeed_share(self) -> float:
        """alpha, [-]."""
        return float(self._state[ALPHA])

    @property
    def heading_bias(self) -> float:
        """Beta in [rad]."""
        return float(self._state[BETA])

    def believed(
        self,
        time: float,
        position: NDArray[np.float64],
        ground_velocity: NDArray[np.float64],
        noise: tuple[float, ...] = UNKNOWN,
    ) -> NDArray[np.float64]:
        """The ground velocity, or what is expected in its place, shape (3,), in [m/s].

        Args:
            time: Of the measurement in [s].
            position: As measured, shape (3,), in [m].
            ground_velocity: As measured, shape (3,), in [m/s].
            noise: Its standard deviation on each axis by the source, shape (3,), in [m/s].
        """
        elapsed = math.inf if self._time is None else time - self._time
        self._judged_at, self._velocity = time, Velocity.EXPECTED
        state = self._state
        expected = self._air + state[W] + state[G] + state[B]
        if not 0.0 <= elapsed <= LONGEST_GAP:
            self._check.reset()
        else:
            variance = float(self._covariance[_OF_VELOCITY].sum()) + max(noise) ** 2
            deviation = math.sqrt(max(variance, 0.0))
            seen = elapsed, position, ground_velocity, expected, deviation
            self._velocity = self._check.judge(*seen)
        self.velocity = OFF if self._velocity is Velocity.ODD else USED
        return expected if self._velocity is Velocity.ODD else ground_velocity

    def update(
        self,
        time: float,
        position: NDArray[np.float64],
        ground_velocity: NDArray[np.float64],
        air_velocity: NDArray[np.float64],
        height: float,
        position_noise: tuple[float, ...] = UNKNOWN,
        velocity_noise: tuple[float, ...] = UNKNOWN,
        loose: ArrayLike = UNKNOWN,
    ) -> None:
        """Take in a measurement.

        Args:
            time: Of the measurement in [s].
            position: As measured, shape (3,), in [m].
            ground_velocity: As measured, shape (3,), in [m/s].
            air_velocity: a, as measured, shape (3,), in [m/s].
            height: Above ground in [m], for the length of the gusts.
            position_noise: Standard deviation on each axis of ``map`` by the source, shape (3,), in
                [m]; zeros where it is unknown.
            velocity_noise: Of the ground velocity, likewise, in [m/s].
            loose: Direction in which the air velocity is a guess, times its deviation, shape (3,),
                in [m/s].
        """
        if time != self._judged_at:
            self.believed(time, position, ground_velocity, velocity_noise)
        elapsed = math.inf if self._time is None else time - self._time
        self._time = time
        self._air_before[:], self._air[:] = self._air, air_velocity
        self._ground_before = self._measured[3:6].copy()
        self._measured[:3], self._measured[3:6] = position, ground_velocity
        self._measured[6:9], self._measured[9:12] = position_noise, velocity_noise
        self._measured[12:] = loose
        if not 0.0 <= elapsed <= LONGEST_GAP:
            self._begin(position_noise)
        elif self._velocity is Velocity.EXPECTED:
            self._go_on(elapsed, height)
        else:
            if self._velocity is Velocity.NEW:
                self.reset()
                self._time, self._air[:] = time, air_velocity
            self._begin(position_noise)
            return
        if elapsed <= LONGEST_GAP and not self._place_fits(elapsed):
            self._measured[:3] = self._carried
        self._meters.begin(time)
        self._update.evaluate()
        results = self._update.results
        self._steady_air[:], (self._scalars[1],) = results[:2]
        self._state[:], self._covariance[:], self._meters.state[:] = results[2:5]
        self._meters.keep(results[5])

    def _place_fits(self, elapsed: float) -> bool:
        """Whether the position is to be used: not one that repeats the last or that has jumped.

        One that has jumped is used if it stays where it is.
        """
        measured, state = self._measured, self._state
        mean = 0.5 * (self._ground_before + measured[3:6])
        self._carried = state[P] + elapsed * (mean - state[B])
        repeated = np.array_equal(measured[:3], self._last)
        self._last[:] = measured[:3]
        self._faded *= math.exp(-elapsed / FADE_TIME)
        offset = measured[:3] - self._carried
        most = JUMP + DEVIATIONS * max(math.sqrt(self._meters.state[-1]), *measured[6:9].tolist())
        far = bool(offset @ offset > most * most)
        self._jumped = self._jumped + elapsed if far else 0.0
        if repeated or not far:
            self.place = STUCK if repeated and far else USED
            return not repeated
        if self._jumped < JUMP_TIME:
            self.place = JUMPED
            return False
        self._faded += state[P] - measured[:3]
        state[P], self._jumped, self.place = measured[:3], 0.0, USED
        return True

    def _begin(self, noise: tuple[float, ...]) -> None:
        """The position begins anew, whatever was known of it."""
        self._state[P] = self._measured[:3]
        self._covariance[_OF_POSITION] = 0.0
        self._covariance[_DIAGONAL[P]] = np.square(np.maximum(noise, POSITION_NOISE))
        self._air_before[:] = self._steady_air[:] = self._air
        self._scalars[:] = 0.0

    def _go_on(self, elapsed: float, height: float) -> None:
        """How far it goes on, and how long gusts last there."""
        self._scalars[0] = elapsed
        east, north, up = (0.5 * (self._air + self._air_before)).tolist()
        speed = max(math.sqrt(east * east + north * north + up * up), 1.0)
        scales = gust_scales(height, 0.0)
        self._times[:2], self._times[2] = scales.long / speed, scales.short / speed


_ROWS, _COLUMNS = (index.T[np.tril_indices(SIZE)] for index in np.indices((SIZE, SIZE)))
_DIAGONAL = np.flatnonzero(_ROWS == _COLUMNS)
_OF_VELOCITY = _DIAGONAL[W.start : B.stop]
_OF_POSITION = np.flatnonzero(P.stop > _ROWS)


def _meters() -> NoiseMeters:
    """Of the horizontal wind triangle, the vertical one, and the position."""
    level, vertical = Signal(2, VELOCITY_NOISE, GUST_WALK), Signal(1, VELOCITY_NOISE, GUST_WALK)
    return NoiseMeters([level, vertical, Signal(3, POSITION_NOISE)], MEMORY)


@functools.cache
def _function() -> ca.Function:
    """An update as a CasADi function, of and to what :class:`WindFilter` holds."""
    scalars = ca.SX.sym("scalars", 2)
    elapsed, turn_rate = scalars[0], scalars[1]
    before, air, steady, times = (ca.SX.sym(n, 3) for n in ("before", "air", "steady", "T"))
    state, triangle = ca.SX.sym("state", SIZE), ca.SX.sym("P", len(_ROWS))
    meters = _meters()
    known, compared = ca.SX.sym("m", len(meters.state)), ca.SX.sym("c", len(meters.compared))
    measured = ca.SX.sym("measured", 15)
    position, velocity, position_noise, velocity_noise, loose = ca.vertsplit(measured, 3)
    arguments = [scalars, before, air, steady, times, state, triangle, known, compared, measured]

    steady, turn_rate = _averaged(elapsed, turn_rate, before, air, steady)
    covariance = ca.triu2symm(ca.SX(ca.Sparsity.upper(SIZE), triangle))
    mean = 0.5 * (before + air)
    level_walk, vertical_walk, _ = ca.vertsplit(meters.walks(known))
    walk = ca.vertcat(level_walk, level_walk, vertical_walk)
    state, covariance = _predicted(elapsed, mean, steady, state, covariance, times, walk)
    covariance[P, P] += elapsed**2 * (loose @ loose.T)  # where it went in between is a guess too
    wind = velocity - air + _beside(state, air)
    sample = ca.vertcat(wind, position - state[P])
    told, told_velocity = position_noise**2, velocity_noise**2
    told_mean = ca.sum1(told) / 3.0
    told_level = 0.5 * (told_velocity[0] + told_velocity[1])
    by_source = ca.vertcat(told_level, told_velocity[2], told_mean)
    metered, variance = meters.metered(known, compared, sample, by_source)
    share = ca.if_else(told_mean > 0.0, told / told_mean, 1.0)
    noise = ca.vertcat(
        ca.fmax(variance[2] * share, POSITION_NOISE**2),
        *[ca.fmax(variance[k], VELOCITY_NOISE**2) for k in (0, 0, 1)],
    )
    seen = ca.vertcat(position, velocity)
    guessed = ca.vertcat(ca.SX.zeros(3), loose)
    state, covariance = _corrected(air, steady, state, covariance, seen, noise, guessed)
    upper = ca.vertcat(*[covariance[r, c] for r, c in zip(_ROWS, _COLUMNS, strict=True)])
    return ca.Function("wind_filter", arguments, [steady, turn_rate, state, upper, metered, sample])


def _averaged(
    elapsed: ca.SX, turn_rate: ca.SX, before: ca.SX, air: ca.SX, steady: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Air velocity followed slowly, without a lag where it turns steadily; and its turn rate."""
    share = ca.fmin(elapsed / AVERAGING_TIME, 1.0)
    x, y, x_after, y_after = before[0], before[1], air[0], air[1]
    turned = ca.atan2(x * y_after - y * x_after, x * x_after + y * y_after)
    turn_rate += (turned - elapsed * turn_rate) / AVERAGING_TIME
    turn = elapsed * turn_rate
    level = ca.cos(turn) * steady + ca.sin(turn) * _across(steady)
    turned_air = ca.vertcat(level[:2], steady[2])
    return turned_air + share * (air - turned_air), turn_rate


def _predicted(
    elapsed: ca.SX,
    air: ca.SX,
    steady: ca.SX,
    state: ca.SX,
    covariance: ca.SX,
    times: ca.SX,
    walks: ca.SX,
) -> tuple[ca.SX, ca.SX]:
    """State and covariance after a time in a mean air velocity."""
    decay = ca.exp(-elapsed / times)
    transition = ca.SX(ca.DM.eye(SIZE))
    for axis in range(3):
        transition[G.start + axis, G.start + axis] = decay[axis]
        transition[axis, W.start + axis] = elapsed
        transition[axis, G.start + axis] = 0.5 * elapsed * (1.0 + decay[axis])
        transition[axis, ALPHA] = -elapsed * steady[axis]
    lasts = ca.exp(-elapsed / TREND_TIME)
    for axis in range(2):
        transition[W.start + axis, T.start + axis] = elapsed
        transition[T.start + axis, T.start + axis] = lasts
    for axis, across in enumerate(ca.vertsplit(-elapsed * _across(steady))[:2]):
        transition[axis, BETA] = across
    after = transition @ state
    after[P] += elapsed * (air - _beside(state, air - steady))
    spread = ca.SX.zeros(SIZE)
    # A random walk of intensity q is a short piece of a gust of variance q T / 2.
    spread[G] = 0.5 * walks * times * (1.0 - decay**2)
    spread[W], spread[B] = WIND_WALK**2 * elapsed, GROUND_WALK**2 * elapsed
    spread[T] = TREND**2 * (1.0 - lasts**2)
    spread[ALPHA], spread[BETA] = SHARE_WALK**2 * elapsed, HEADING_WALK**2 * elapsed
    return after, transition @ covariance @ transition.T + ca.diag(spread)


def _corrected(
    air: ca.SX,
    steady: ca.SX,
    state: ca.SX,
    covariance: ca.SX,
    measured: ca.SX,
    noise: ca.SX,
    guessed: ca.SX,
) -> tuple[ca.SX, ca.SX]:
    """State and covariance, in its upper triangle, with position and ground velocity measured."""
    sensed = ca.SX(6, SIZE)
    across = _across(steady)
    for axis in range(3):
        sensed[axis, axis] = 1.0
        for part in (W, G, B):
            sensed[3 + axis, part.start + axis] = 1.0
        sensed[3 + axis, ALPHA] = -steady[axis]
    sensed[3, BETA], sensed[4, BETA] = -across[0], -across[1]
    apart = air - steady
    explained = sensed @ state + ca.vertcat(ca.SX.zeros(3), air - _beside(state, apart))
    crossed = sensed @ covariance
    spread = crossed @ sensed.T + ca.diag(noise) + guessed @ guessed.T
    gain = _solved(spread, crossed).T
    # Heading and airspeed are sure while the aircraft turns as it did over the average.
    is_steady = ca.sumsqr(apart) <= STEADY_SHARE**2 * ca.sumsqr(air)
    gain[ALPHA:, :] *= is_steady
    # Of the consider filter too this is the upper triangle: alpha and beta come last.
    return state + gain @ (measured - explained), covariance - gain @ crossed


def _beside(state: ca.SX, apart: ca.SX) -> ca.SX:
    """What alpha and beta change of an air velocity beyond what they do of the average.

    Args:
        state: Of the filter, shape (14,).
        apart: The air velocity less its average, shape (3,), in [m/s].
    """
    return state[ALPHA] * apart + state[BETA] * _across(apart)


def _across(velocity: ca.SX) -> ca.SX:
    """e_z x v, shape (3,)."""
    return ca.vertcat(-velocity[1], velocity[0], 0.0)


def _solved(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """A^-1 B of a positive definite A, by its Cholesky factor."""
    factor = ca.chol(matrix)  # upper: A = R^T R
    size = matrix.size1()
    rows: list[ca.SX] = []
    for row in range(size):
        known = sum((factor[k, row] * rows[k] for k in range(row)), ca.SX.zeros(right[0, :].shape))
        rows.append((right[row, :] - known) / factor[row, row])
    for row in reversed(range(size)):
        for k in range(row + 1, size):
            rows[row] = rows[row] - factor[row, k] * rows[k]
        rows[row] = rows[row] / factor[row, row]
    return ca.vertcat(*rows)
