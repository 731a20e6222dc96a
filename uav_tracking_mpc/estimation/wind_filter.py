r"""Mean wind, gusts and sensor biases, from positions, ground velocities and air velocities.

A Kalman filter. With a the air velocity as heading, path angle and airspeed tell it,
:math:`\alpha` the share by which the airspeed reads too much, :math:`\beta` the angle by which the
heading reads too far to the left, w the mean wind, g the gust and b the bias of the ground
velocity,

.. math::

    p' = a - \alpha a - \beta\, e_z \times a + w + g,\qquad
    p_{measured} = p,\qquad v_{measured} = p' + b.

Gusts are coloured noise, :math:`g' = -g / T + n`, with the correlation time T = L / V of the
Dryden spectra (:mod:`~uav_tracking_mpc.dynamics.dryden`; the longitudinal form on all axes).
Everything else wanders slowly. How strong the gusts are and how noisy the velocities is not told
but seen. A bias of the ground velocity shows at once beside the positions, those of heading and
airspeed while the aircraft turns, for they turn with it and the wind does not. While it rolls into
a turn or out of it a real aircraft slips: its heading is then off by degrees, and alpha and beta
are considered (Schmidt 1966) but not estimated.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.dryden import gust_scales
from uav_tracking_mpc.estimation.noise_meter import MEMORY, NoiseMeter

# Standard deviations before anything is measured
WIND, GUST, GROUND_BIAS = 10.0, 2.5, 2.0  # m/s
AIRSPEED_SHARE, HEADING_BIAS = 0.02, 0.02  # -, rad
# How much what is constant may wander, in its unit per root of s
WIND_WALK, GROUND_WALK, SHARE_WALK, HEADING_WALK = 0.03, 0.01, 2e-4, 2e-4
POSITION_NOISE, VELOCITY_NOISE = 0.1, 0.05  # m, m/s: least standard deviations believed
GUST_WALK = 1.0  # m^2/s^3, that of moderate gusts, until it is seen how strong they are
# Over which the air velocity is averaged that multiplies alpha and beta. A gust changes the
# airspeed of a real aircraft, and its heading as it weathercocks, before it moves the aircraft:
# v_measured - a then changes exactly as -a does, and the gust would be taken for alpha.
AVERAGING_TIME = 5.0  # s
STEADY_SHARE = 0.1  # of the airspeed, that the air velocity may be apart from its average
LONGEST_GAP = 2.0  # s without a measurement, after which the position begins anew

P, W, G, B = (slice(3 * k, 3 * k + 3) for k in range(4))
ALPHA, BETA, SIZE = 12, 13, 14


class WindFilter:
    """The filter of the module's docstring; its state is (p, w, g, b, alpha, beta)."""

    def __init__(self) -> None:
        self._position_meter = NoiseMeter(POSITION_NOISE, MEMORY)
        self._level_meter = NoiseMeter(VELOCITY_NOISE, MEMORY, GUST_WALK)
        self._vertical_meter = NoiseMeter(VELOCITY_NOISE, MEMORY, GUST_WALK)
        self._transition = np.eye(SIZE)
        self._sensed = np.zeros((6, SIZE))  # of position and ground velocity
        axes = np.arange(3)
        self._sensed[axes, axes] = 1.0
        for part in (W, G, B):
            self._sensed[3 + axes, part.start + axes] = 1.0
        self._spread, self._noise = np.zeros(SIZE), np.zeros(6)
        self.reset()

    def reset(self) -> None:
        """Forget air and biases."""
        for meter in (self._position_meter, self._level_meter, self._vertical_meter):
            meter.reset()
        self._time: float | None = None
        self._state = np.zeros(SIZE)
        deviations = [POSITION_NOISE, WIND, GUST, GROUND_BIAS]
        prior = [*np.repeat(deviations, 3), AIRSPEED_SHARE, HEADING_BIAS]
        self._covariance = np.diag(np.square(prior))
        self._air, self._steady_air, self._turn_rate = np.zeros(3), np.zeros(3), 0.0
        self.correlation_times = np.ones(3)

    @property
    def position(self) -> NDArray[np.float64]:
        """P at the newest measurement, shape (3,), in [m]."""
        return self._state[P].copy()

    @property
    def mean_wind(self) -> NDArray[np.float64]:
        """w, shape (3,), in [m/s]."""
        return self._state[W].copy()

    @property
    def gust(self) -> NDArray[np.float64]:
        """G at the newest measurement, shape (3,), in [m/s]."""
        return self._state[G].copy()

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

    def update(
        self,
        time: float,
        position: NDArray[np.float64],
        ground_velocity: NDArray[np.float64],
        air_velocity: NDArray[np.float64],
        height: float,
    ) -> None:
        """Take in a measurement.

        Args:
            time: Of the measurement in [s].
            position: As measured, shape (3,), in [m].
            ground_velocity: As measured, shape (3,), in [m/s].
            air_velocity: a, as measured, shape (3,), in [m/s].
            height: Above ground in [m], for the length of the gusts.
        """
        elapsed = math.inf if self._time is None else time - self._time
        self._time = time
        if not 0.0 <= elapsed <= LONGEST_GAP:
            self._state[P] = position
            self._covariance[P, :] = self._covariance[:, P] = 0.0
            self._covariance[P, P] = POSITION_NOISE**2 * np.eye(3)
            self._steady_air, self._turn_rate = air_velocity.copy(), 0.0
        else:
            self._average(elapsed, air_velocity)
            self._predict(elapsed, air_velocity, height)
        self._air = air_velocity
        self._see_noise(time, position, ground_velocity)
        self._correct(position, ground_velocity)

    def _average(self, elapsed: float, air_velocity: NDArray[np.float64]) -> None:
        """Follow the air velocity slowly, without a lag where it turns steadily."""
        share = min(elapsed / AVERAGING_TIME, 1.0)
        (x, y, _), (x_after, y_after, _) = self._air.tolist(), air_velocity.tolist()
        turned = math.atan2(x * y_after - y * x_after, x * x_after + y * y_after)
        self._turn_rate += (turned - elapsed * self._turn_rate) / AVERAGING_TIME
        turn = elapsed * self._turn_rate
        steady = self._steady_air
        turned_air = math.cos(turn) * steady + math.sin(turn) * _across(steady)
        turned_air[2] = steady[2]
        self._steady_air = turned_air + share * (air_velocity - turned_air)

    def _predict(self, elapsed: float, air_velocity: NDArray[np.float64], height: float) -> None:
        air = 0.5 * (self._air + air_velocity)
        speed = max(float(np.linalg.norm(air)), 1.0)
        scales = gust_scales(height, 0.0)
        self.correlation_times[:] = scales.long / speed, scales.long / speed, scales.short / speed
        decay = np.exp(-elapsed / self.correlation_times)
        axes, transition = np.arange(3), self._transition
        transition[G.start + axes, G.start + axes] = decay
        transition[axes, W.start + axes] = elapsed
        transition[axes, G.start + axes] = 0.5 * elapsed * (1.0 + decay)
        transition[P, ALPHA] = -elapsed * self._steady_air
        transition[P, BETA] = -elapsed * _across(self._steady_air)
        self._state = transition @ self._state
        self._state[P] += elapsed * (air - self._beside(air))
        # A random walk of intensity q is a short piece of a gust of variance q T / 2.
        walks = np.array([self._level_meter.walk] * 2 + [self._vertical_meter.walk])
        self._spread[G] = 0.5 * walks * self.correlation_times * (1.0 - decay**2)
        self._spread[W], self._spread[B] = WIND_WALK**2 * elapsed, GROUND_WALK**2 * elapsed
        self._spread[ALPHA:] = SHARE_WALK**2 * elapsed, HEADING_WALK**2 * elapsed
        self._covariance = transition @ self._covariance @ transition.T
        self._covariance.flat[:: SIZE + 1] += self._spread

    def _beside(self, air: NDArray[np.float64]) -> NDArray[np.float64]:
        """What alpha and beta change of an air velocity beyond what they do of the average."""
        apart = air - self._steady_air
        return self._state[ALPHA] * apart + self._state[BETA] * _across(apart)

    def _see_noise(
        self, time: float, position: NDArray[np.float64], ground_velocity: NDArray[np.float64]
    ) -> None:
        air, alpha, beta = self._air, self._state[ALPHA], self._state[BETA]
        wind = ground_velocity - (air - alpha * air - beta * _across(air))
        self._level_meter.see(time, wind[:2])
        self._vertical_meter.see(time, wind[2:])
        self._position_meter.see(time, position - self._state[P])
        self._noise[:3] = max(self._position_meter.variance, POSITION_NOISE**2)
        self._noise[3:5] = max(self._level_meter.variance, VELOCITY_NOISE**2)
        self._noise[5] = max(self._vertical_meter.variance, VELOCITY_NOISE**2)

    def _correct(self, position: NDArray[np.float64], ground_velocity: NDArray[np.float64]) -> None:
        sensed, air = self._sensed, self._air
        sensed[3:, ALPHA], sensed[3:, BETA] = -self._steady_air, -_across(self._steady_air)
        innovation = np.concatenate([position, ground_velocity - air]) - sensed @ self._state
        innovation[3:] += self._beside(air)
        crossed = sensed @ self._covariance
        variance = crossed @ sensed.T
        variance.flat[::7] += self._noise
        gain = np.linalg.solve(variance, crossed).T
        if not self._steady:
            gain[ALPHA:] = 0.0
        self._state = self._state + gain @ innovation
        change = gain @ crossed
        covariance = self._covariance - change
        if not self._steady:
            covariance[ALPHA:, :ALPHA] = covariance[:ALPHA, ALPHA:].T
        self._covariance = 0.5 * (covariance + covariance.T)

    @property
    def _steady(self) -> bool:
        """Whether the aircraft turns as it did over the average: heading and airspeed are sure."""
        apart = self._air - self._steady_air
        return float(apart @ apart) <= (STEADY_SHARE * float(np.linalg.norm(self._air))) ** 2


def _across(velocity: NDArray[np.float64]) -> NDArray[np.float64]:
    """e_z x v, shape (3,)."""
    east, north, _ = velocity
    return np.array([-north, east, 0.0])
