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
estimated.

These are expressions: :mod:`~uav_tracking_mpc.estimation.air_estimate` compiles them.
"""

from __future__ import annotations

from types import SimpleNamespace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.noise_meter import NoiseMeters
from uav_tracking_mpc.symbolic.layout import Layout

# Standard deviations before anything is measured
WIND, GUST, GROUND_BIAS = 10.0, 2.5, 2.0  # m/s
BIAS = 0.02  # rad, of beta; and -, of alpha
# How much what is constant may wander. An autopilot's filter whose accelerometers shake errs by
# 0.25 m/s of level ground velocity for some seconds, which its positions show. A climb is not
# trusted less for that: it carries on a height that is stuck.
WIND_WALK, GROUND_WALK = 0.03, (0.03, 0.03, 0.01)  # m/s per root of s
BIAS_WALK = 2e-4  # rad per root of s, of beta; of alpha likewise
BIAS_TIME = 3.0  # s, after which alpha is as uncertain as what nothing else explains
POSITION_NOISE, VELOCITY_NOISE = 0.1, 0.05  # m, m/s: least standard deviations believed
GUST_WALK = 1.0  # m^2/s^3, that of moderate gusts, until it is seen how strong they are
TREND, TREND_TIME = 0.03, 60.0  # m/s^2, s: deviation of the wind's change, how long it lasts
# Over which the air velocity is averaged that multiplies alpha and beta. A gust changes the
# airspeed of a real aircraft, and its heading as it weathercocks, before it moves the aircraft:
# v_measured - a then changes exactly as -a does, and the gust would be taken for alpha.
AVERAGING_TIME = 5.0  # s
# -, of the airspeed, that the air velocity may be apart from its average in calm air; and how much
# closer its square must be in moderate gusts: what the average takes up of one is taken for alpha
# all the same, and in an hour of gusts the aircraft would fly a tenth too fast
STEADY_SHARE, CLOSER = 0.1, 10.0

P, W, G, B = (slice(3 * k, 3 * k + 3) for k in range(4))
T = slice(12, 14)
ALPHA, BETA, SIZE = 14, 15, 16  # -, index of both, and how many states
STATE = Layout(position=3, wind=3, gust=3, bias=3, trend=2, alpha=1, beta=1)  # the same by names
# What one filter knows: air velocity before, its average, turn rate of that, the state
# (p, w, g, b, t, alpha, beta), and the upper triangle of its covariance by columns.
_ROWS, _COLUMNS = (index.T[np.tril_indices(SIZE)] for index in np.indices((SIZE, SIZE)))
DIAGONAL = np.flatnonzero(_ROWS == _COLUMNS)
_PRIOR = np.repeat([POSITION_NOISE, WIND, GUST, GROUND_BIAS, 0.2 * TREND, BIAS], [3, 3, 3, 3, 2, 2])
LANE = Layout(
    air=3, steady=3, turn_rate=1, state=SIZE, triangle=np.diag(_PRIOR**2)[_ROWS, _COLUMNS]
)
_OF_POSITION = np.flatnonzero(P.stop > _ROWS)
# Of the wind triangle, level and vertical, and of the position.
METERS = NoiseMeters((2, 1), (VELOCITY_NOISE, VELOCITY_NOISE), (GUST_WALK, GUST_WALK))
PLACES = NoiseMeters((3,), (POSITION_NOISE,), (0.0,), jumping=True)


# Which part of a gust lasts
SLOW_TIME = 2.0  # s, over which gusts are averaged; the rest is quick
QUICK_TIME = 0.5  # s, over which the quick part is averaged to see whether it lasts
MEMORY_TIME = 20.0  # s, of its mean squares
LEAST_QUICK = 0.1  # m/s, of quick parts that are too small to tell
SHAKES, LASTS = 0.60, 0.70  # -, correlation of the quick part at which none of it counts, and all
BY_SENSORS = 0.5  # -, share of it by noise of heading and airspeed, at which all of it counts
QUICK = Layout(slow=3, averaged=3, means=6)

# What positions alone tell of the ground velocity: up to which frequency, and how exactly
FOLLOWED, FOLLOWED_DEVIATION = 1.0, 1.0  # rad/s, m/s
FOLLOWER = Layout(place=3, velocity=3)


def begin_position(
    lane: SimpleNamespace, position: NDArray[np.float64], noise: NDArray[np.float64]
) -> None:
    """Let the position begin anew, whatever was known of it.

    Args:
        lane: Views of a filter's numbers by :data:`LANE`.
        position: As measured, shape (3,), in [m].
        noise: Its standard deviations, shape (3,), in [m]; 0 where unknown.
    """
    lane.state[P] = position
    lane.triangle[_OF_POSITION] = 0.0
    lane.triangle[DIAGONAL[P]] = np.square(np.maximum(noise, POSITION_NOISE))
    lane.turn_rate[:] = 0.0


def predicted(
    lane: SimpleNamespace,
    elapsed: ca.SX,
    air: ca.SX,
    scales: ca.SX,
    loose: ca.SX,
    walks: ca.SX,
    unexplained: ca.SX,
) -> SimpleNamespace:
    """A filter after a time, before it is corrected.

    Args:
        lane: Before, by :data:`LANE`.
        elapsed: In [s]; 0 where the flight begins.
        air: a as it is measured now, shape (3,), in [m/s].
        scales: Lengths of gusts on each axis, shape (3,), in [m].
        loose: Directions in which a is a guess, times its deviation, shape (3, n), in [m/s].
        walks: Intensities of the level and the vertical gusts in [m^2/s^3].
        unexplained: By how much the airspeed differs from what all others tell in [m/s].

    Returns:
        As :data:`LANE`, but the covariance as a matrix; and the gusts' correlation times [s].
    """
    begins = elapsed <= 0.0
    before = ca.if_else(begins, air, lane.air)
    steady = ca.if_else(begins, air, lane.steady)
    steady, turn_rate = _averaged(elapsed, lane.turn_rate, before, air, steady)
    mean = 0.5 * (before + air)
    times = scales / ca.fmax(ca.norm_2(mean), 1.0)
    decay, lasts = ca.exp(-elapsed / times), ca.exp(-elapsed / TREND_TIME)
    transition = ca.SX(ca.DM.eye(SIZE))
    transition[G, G] = ca.diag(decay)
    transition[P, W] = elapsed * ca.DM.eye(3)
    transition[P, G] = ca.diag(0.5 * elapsed * (1.0 + decay))
    transition[P, ALPHA] = -elapsed * steady
    transition[P.start : P.stop - 1, BETA] = -elapsed * _across(steady)[:2]
    transition[W.start : W.stop - 1, T] = elapsed * ca.DM.eye(2)
    transition[T, T] = lasts * ca.DM.eye(2)
    state = transition @ lane.state
    state[P] += elapsed * (mean - _beside(lane.state, mean - steady))
    spread = ca.SX.zeros(SIZE)
    # A random walk of intensity q is a short piece of a gust of variance q T / 2.
    spread[G] = 0.5 * ca.vertcat(walks[0], walks[0], walks[1]) * times * (1.0 - decay**2)
    spread[W], spread[B] = WIND_WALK**2 * elapsed, np.square(GROUND_WALK) * elapsed
    spread[T] = TREND**2 * (1.0 - lasts**2)
    spread[ALPHA:] = BIAS_WALK**2 * elapsed
    spread[ALPHA] += (unexplained / ca.fmax(ca.norm_2(steady), 1.0)) ** 2 * elapsed / BIAS_TIME
    covariance = ca.triu2symm(ca.SX(ca.Sparsity.upper(SIZE), lane.triangle))
    covariance = transition @ covariance @ transition.T + ca.diag(spread)
    covariance[P, P] += elapsed**2 * (loose @ loose.T)  # where it went in between is a guess too
    return SimpleNamespace(
        air=air,
        steady=steady,
        turn_rate=turn_rate,
        state=state,
        covariance=covariance,
        loose=loose,
        times=times,
        walk=walks[0],
    )


def lasting_gust(
    known: SimpleNamespace, elapsed: ca.SX, gust: ca.SX, lane: SimpleNamespace
) -> tuple[SimpleNamespace, ca.SX]:
    """What is known of gusts after one, and the part of it that a plan should count on, in [m/s].

    A gust that fades slowly stays alike over half a second, also the quick part of it. What shakes
    the aircraft does not: turbulence that is shorter than the wing answers, and the swing of its
    own slip. To answer those takes longer than they last. Where heading and airspeed shake instead,
    the gust must be kept: it is what they err by.

    Args:
        known: By :data:`QUICK`.
        elapsed: Since the one before in [s].
        gust: Shape (3,), in [m/s].
        lane: As predicted, velocities in [m/s].
    """
    across = _across(lane.steady) / ca.fmax(ca.norm_2(lane.steady), 1.0)

    def seen(one: ca.SX, other: ca.SX) -> ca.SX:  # products across the flight, and up
        return ca.vertcat(ca.dot(across, one) * ca.dot(across, other), one[2] * other[2])

    slow = known.slow + (1.0 - ca.exp(-elapsed / SLOW_TIME)) * (gust - known.slow)
    quick = gust - slow
    averaged = known.averaged + (1.0 - ca.exp(-elapsed / QUICK_TIME)) * (quick - known.averaged)
    share, floor = elapsed / MEMORY_TIME, LEAST_QUICK**2
    now = [seen(quick, each) for each in (quick, averaged, lane.steady - lane.air)]
    means = known.means + share * (ca.vertcat(*now) - known.means)
    squares, products, by_sensors = ca.vertsplit(means, 2)
    counts = _between((products + floor) / (squares + floor), SHAKES, LASTS)
    counts = ca.fmax(counts, _between(by_sensors / (squares + floor), 0.0, BY_SENSORS))
    after = SimpleNamespace(slow=slow, averaged=averaged, means=means)
    return after, slow + ca.vertcat(counts[0], counts[0], counts[1]) * quick


def _between(values: ca.SX, least: float, most: float) -> ca.SX:
    """0 at the least and below, 1 at the most and beyond."""
    return ca.fmin(ca.fmax((values - least) / (most - least), 0.0), 1.0)


def through_air(lane: SimpleNamespace) -> ca.SX:
    """Velocity through the air as it is measured, less alpha and beta, shape (3,), in [m/s].

    Args:
        lane: As predicted.
    """
    return lane.air - _beside(lane.state, lane.air)


def corrected(lane: SimpleNamespace, measured: ca.SX, noise: ca.SX) -> SimpleNamespace:
    """A filter with position and ground velocity measured, by :data:`LANE`.

    Args:
        lane: As predicted.
        measured: Position [m] and ground velocity [m/s], shape (6,).
        noise: Variances of these, shape (6,).
    """
    air, steady, state, covariance = lane.air, lane.steady, lane.state, lane.covariance
    sensed, apart = ca.SX(6, SIZE), air - steady
    sensed[:3, P] = sensed[3:, W] = sensed[3:, G] = sensed[3:, B] = ca.DM.eye(3)
    sensed[3:, ALPHA], sensed[3:5, BETA] = -steady, -_across(steady)[:2]
    explained = sensed @ state + ca.vertcat(ca.SX.zeros(3), air - _beside(state, apart))
    crossed = sensed @ covariance
    spread = crossed @ sensed.T + ca.diag(noise)
    spread[3:, 3:] += lane.loose @ lane.loose.T
    factor = ca.chol(spread)  # upper: R^T R
    gain = ca.solve(factor, ca.solve(factor.T, crossed)).T
    # Heading and airspeed are sure while the aircraft turns as it did over the average.
    closer = 1.0 + CLOSER * (lane.walk / GUST_WALK) ** 2
    gain[ALPHA:, :] *= closer * ca.sumsqr(apart) <= STEADY_SHARE**2 * ca.sumsqr(air)
    after = state + gain @ (measured - explained)
    # Of the consider filter too this is the upper triangle: alpha and beta come last.
    covariance -= gain @ crossed
    triangle = [covariance[r, c] for r, c in zip(_ROWS, _COLUMNS, strict=True)]
    return SimpleNamespace(**vars(lane) | {"state": after, "triangle": ca.vertcat(*triangle)})


def followed(
    known: SimpleNamespace, elapsed: ca.SX, position: ca.SX, fresh: ca.SX, acceleration: ca.SX
) -> tuple[SimpleNamespace, ca.SX]:
    """What is known after a position, and the velocity over ground by positions, in [m/s].

    Args:
        known: By :data:`FOLLOWER`.
        elapsed: Since the measurement before in [s].
        position: As measured, shape (3,), in [m].
        fresh: 1 where one is measured that is not the one before, else 0.
        acceleration: By which the velocity turns, shape (3,), in [m/s^2].
    """
    velocity = known.velocity + elapsed * acceleration
    place = known.place + 0.5 * elapsed * (known.velocity + velocity)
    error = fresh * (position - place)
    step = ca.fmin(elapsed, 0.5 / FOLLOWED)  # else it would not come to rest
    velocity += FOLLOWED**2 * step * error
    place += 2.0 * FOLLOWED * step * error
    return SimpleNamespace(place=place, velocity=velocity), velocity


def _averaged(
    elapsed: ca.SX, turn_rate: ca.SX, before: ca.SX, air: ca.SX, steady: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """Air velocity followed slowly, without a lag where it turns steadily; and its turn rate."""
    turned = ca.atan2(ca.dot(_across(before), air), ca.dot(before[:2], air[:2]))
    turn_rate += (turned - elapsed * turn_rate) / AVERAGING_TIME
    turn = elapsed * turn_rate
    level = ca.cos(turn) * steady + ca.sin(turn) * _across(steady)
    turned_air = ca.vertcat(level[:2], steady[2])
    return turned_air + ca.fmin(elapsed / AVERAGING_TIME, 1.0) * (air - turned_air), turn_rate


def _beside(state: ca.SX, apart: ca.SX) -> ca.SX:
    """What alpha and beta change of an air velocity beyond what they do of the average.

    Args:
        state: Of the filter, shape (16,).
        apart: The air velocity less its average, shape (3,), in [m/s].
    """
    return state[ALPHA] * apart + state[BETA] * _across(apart)


def _across(velocity: ca.SX) -> ca.SX:
    """e_z x v, shape (3,)."""
    return ca.vertcat(-velocity[1], velocity[0], 0.0)
