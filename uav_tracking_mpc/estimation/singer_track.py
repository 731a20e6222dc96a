r"""Position, velocity and acceleration of one target: a Kalman filter on Singer's model.

R. A. Singer, "Estimating Optimal Tracking Filter Performance for Manned Maneuvering Targets",
IEEE Trans. Aerospace and Electronic Systems 6(4), 1970: on each axis p' = v, v' = a and

.. math:: a' = -a / \tau + w, \quad E[w(t) w(s)] = (2 \sigma_a^2 / \tau)\, \delta(t - s)

so that the acceleration has standard deviation sigma_a and is forgotten after tau. The axes share
their covariance, which does not depend on the positions but only on their times.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

MANOEUVRE_TIME = 5.0  # tau [s]: least prediction errors on circles, straight runs, stop and go
BRIDGE_TIME = 5.0  # s without a position after which the velocity fades
FADE_TIME = 10.0  # s, its time constant
TURN_MEMORY = 2.0  # s over which the turn rate is averaged
Motion = tuple[NDArray[np.float64], float]  # velocity, shape (3,), and its variance [m^2/s^2]
TERMS = 16  # of the series of exp(-x), x <= 1/2: exact to rounding


def _noise_series() -> NDArray[np.float64]:
    """Coefficients of the entries of Q in powers of x = t / tau, shape (3, 3, n).

    Q is the integral of 2 g g', g = (e^-x - 1 + x, 1 - e^-x, e^-x) being the response to an
    impulse of w. Its closed form cancels to nothing for short times, the series does not.
    """
    decay = np.cumprod(np.append(1.0, -1.0 / np.arange(1, TERMS)))
    position, velocity = decay.copy(), -decay
    position[:2] = velocity[0] = 0.0
    responses = [np.polynomial.Polynomial(series) for series in (position, velocity, decay)]
    products = [2.0 * (one * other).integ() for one in responses for other in responses]
    series = np.array([product.coef[:TERMS] for product in products]).reshape(3, 3, TERMS)
    orders = np.array([2.0, 1.0, 0.0])  # of tau in g
    return MANOEUVRE_TIME ** np.add.outer(orders, orders)[:, :, None] * series


_NOISE_SERIES = _noise_series()
_POWERS = np.arange(float(TERMS))


def singer_motion(duration: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Transition matrix and covariance of the noise of unit sigma_a.

    Args:
        duration: At least 0, in [s].

    Returns:
        F and Q, shape (3, 3) each.
    """
    x = duration / MANOEUVRE_TIME
    if x > 0.5:
        half, noise = singer_motion(duration / 2.0)
        return half @ half, half @ noise @ half.T + noise
    gone = -math.expm1(-x)
    transition = np.array(
        [
            [1.0, duration, MANOEUVRE_TIME**2 * (x - gone)],
            [0.0, 1.0, MANOEUVRE_TIME * gone],
            [0.0, 0.0, 1.0 - gone],
        ]
    )
    return transition, _NOISE_SERIES @ x**_POWERS


def bridged(age: float) -> tuple[float, float]:
    """Time travelled at the velocity last known, and the share of it that is left.

    A target that is lost is taken to run on for a while and then to slow down, so that no
    position runs away.

    Args:
        age: Of the newest measurement in [s].

    Returns:
        Time in [s], and the share, from 0 to 1.
    """
    if age <= BRIDGE_TIME:
        return age, 1.0
    left = math.exp(-(age - BRIDGE_TIME) / FADE_TIME)
    return BRIDGE_TIME + FADE_TIME * (1.0 - left), left


class SingerTrack:
    """A target that has been seen at least once.

    Args:
        time: When it was first seen in [s].
        position: Where, shape (3,), in [m].
        noise: Standard deviation of a measured position in [m].
        agility: sigma_a in [m/s^2].
        speed: Standard deviation of the velocity before it is known in [m/s].

    Attributes:
        time: Of the newest position taken in, in [s].
        state: Position, velocity and acceleration at that time, rows of shape (3, 3).
        covariance: Of (p, v, a) on each axis at that time, shape (3, 3).
        turn_rate: Of the horizontal velocity, averaged over a few seconds, in [rad/s].
    """

    def __init__(
        self, time: float, position: NDArray[np.float64], noise: float, agility: float, speed: float
    ) -> None:
        self._variance = noise**2
        self._agility = agility
        self.time = time
        self.state = np.zeros((3, 3))
        self.state[0] = position
        self.covariance = np.diag([noise**2, speed**2, agility**2])
        self.turn_rate = 0.0

    def propagated(self, time: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """State and covariance at a later time.

        Args:
            time: Not before that of the track, in [s].

        Returns:
            As the attributes, shape (3, 3) each.
        """
        age = time - self.time
        transition, noise = singer_motion(age)
        covariance = transition @ self.covariance @ transition.T + self._agility**2 * noise
        if age <= BRIDGE_TIME:
            return transition @ self.state, covariance
        travelled, left = bridged(age)
        state = singer_motion(travelled)[0] @ self.state
        state[1:] *= left
        return state, covariance

    def position_std(self, age: float) -> float:
        """Standard deviation of the position on each axis in [m].

        Args:
            age: Of the track, at least 0, in [s].
        """
        transition, noise = singer_motion(age)
        row = transition[0]
        return math.sqrt(row @ self.covariance @ row + self._agility**2 * noise[0, 0])

    def update(
        self,
        time: float,
        position: NDArray[np.float64],
        gate: float,
        variance: float | None = None,
        motion: Motion | None = None,
    ) -> bool:
        """Take in a position unless its squared normalised innovation exceeds the gate.

        Args:
            time: When it was measured, after that of the track, in [s].
            position: Shape (3,), in [m].
            gate: Greatest squared normalised innovation, chi-square of 3 degrees of freedom, [-].
            variance: Of the position on each axis in [m^2]; that of the first one by default.
            motion: Velocity, shape (3,), in [m/s] and its variance in [m^2/s^2], or None; it is
                left out by itself where it exceeds the gate.
        """
        state, covariance = self.propagated(time)
        innovation = position - state[0]
        variance = self._variance if variance is None else variance
        if not innovation @ innovation <= gate * (covariance[0, 0] + variance):
            return False
        self.state, self.covariance = state, covariance
        self._correct(0, innovation, variance)
        if motion is not None:
            self.see_velocity(*motion, gate)
        self._average_turn(time - self.time)
        self.time = time
        return True

    def see_velocity(self, velocity: NDArray[np.float64], variance: float, gate: float) -> None:
        """Take in a velocity of the track's time unless its innovation exceeds the gate.

        Args:
            velocity: Shape (3,), in [m/s].
            variance: On each axis in [m^2/s^2].
            gate: Greatest squared normalised innovation, [-].
        """
        innovation = velocity - self.state[1]
        if innovation @ innovation <= gate * (self.covariance[1, 1] + variance):
            self._correct(1, innovation, variance)

    def _correct(self, order: int, innovation: NDArray[np.float64], variance: float) -> None:
        """Kalman correction by a measured derivative of the position, of order 0 or 1."""
        covariance = self.covariance
        gain = covariance[:, order] / (covariance[order, order] + variance)
        self.state = self.state + np.outer(gain, innovation)
        # Joseph's form: a sum of squares, whatever is rounded.
        remaining = np.eye(3)
        remaining[:, order] -= gain
        covariance = remaining @ covariance @ remaining.T + variance * np.outer(gain, gain)
        self.covariance = 0.5 * (covariance + covariance.T)

    def _average_turn(self, elapsed: float) -> None:
        (_, (vx, vy, _), (ax, ay, _)) = self.state.tolist()
        # A velocity within its own uncertainty has no direction to turn.
        square = max(vx * vx + vy * vy, 9.0 * float(self.covariance[1, 1]))
        share = 1.0 - math.exp(-elapsed / TURN_MEMORY)
        self.turn_rate += share * ((vx * ay - vy * ax) / square - self.turn_rate)
