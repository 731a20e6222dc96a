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

r"""Wind: a mean, and Dryden gusts about it (MIL-F-8785C, low-altitude model).

With the strengths sigma and lengths L of :mod:`~uav_tracking_mpc.dynamics.air` each component,
flown through at airspeed V, has the one-sided spectrum over :math:`\Omega = \omega / V`

.. math:: \Phi_u = \sigma_u^2 \frac{2 L_u}{\pi} \frac{1}{1 + (L_u \Omega)^2},\qquad
          \Phi_{v,w} = \sigma^2 \frac{L}{\pi} \frac{1 + 3 (L \Omega)^2}{(1 + (L \Omega)^2)^2}

so that over the distance s = V t they correlate as :math:`e^{-s/L}` and
:math:`e^{-s/L} (1 - s / 2L)`.

The longitudinal axis is the horizontal direction of the air velocity, the vertical axis is that of
``map``. The standard asks for the first ("relative mean wind"): a frozen field is met along the
path through the air, and the mean wind over ground plays no part in that.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import gammainc

from uav_tracking_mpc.dynamics.air import GustScales, gust_scales

GUST_STEP = 0.02  # s of flight for which a gust is held
ROOT_2, ROOT_3 = math.sqrt(2.0), math.sqrt(3.0)  # -, of the Dryden spectra, MIL-F-8785C


class ExactStep:
    r"""What happens to (p, m) of :class:`GustFilter` over a distance V dt / L >= 0.

    They decay by exp(-distance), and noise of covariance :math:`P - \Phi P \Phi^T` is added, whose
    entries come from incomplete gamma functions of twice the distance.

    Args:
        distance: In lengths L, [-].

    Attributes:
        distance: As above.
        decay: exp(-distance), [-].
        p_p: Entry 11 of the noise's Cholesky factor, [-].
        p_m: Entry 21, [-].
        m_m: Entry 22, [-].
    """

    __slots__ = ("decay", "distance", "m_m", "p_m", "p_p")

    def __init__(self, distance: float) -> None:
        self.distance, self.decay = distance, math.exp(-distance)
        x = 2.0 * distance
        variance, second = -math.expm1(-x), 0.5 * float(gammainc(3.0, x))
        covariance = second + 0.25 * math.exp(-x) * x * x
        self.p_p = math.sqrt(variance)
        self.p_m = covariance / self.p_p if variance > 0.0 else 0.0
        self.m_m = math.sqrt(max(second - self.p_m**2, 0.0))


class GustFilter:
    """Gusts of unit variance along one length, sampled exactly, stationary from the start.

    Transverse gusts pass white noise through (1 + sqrt(3) L s / V) / (1 + L s / V)^2, written as
    two lags in a row, p' = V/L (-p + noise), m' = V/L (p - m), whose stationary covariance
    [[1, 1/2], [1/2, 1/2]] does not depend on V and L: both may change while it runs. A
    longitudinal gust is p alone.

    Args:
        first: Standard normal number [-].
        second: Another, independent [-].
    """

    def __init__(self, first: float, second: float) -> None:
        self.longitudinal = first
        self._second = 0.5 * (first + second)

    @property
    def transverse(self) -> float:
        """Output of the transverse filter [-]."""
        return (ROOT_3 * self.longitudinal + (1.0 - ROOT_3) * self._second) / ROOT_2

    def step(self, step: ExactStep, first: float, second: float) -> None:
        """Go on by a step.

        Args:
            step: Of the length along which this filter is.
            first: Standard normal number [-].
            second: Another, independent [-].
        """
        self._second = step.decay * (self._second + step.distance * self.longitudinal)
        self._second += step.p_m * first + step.m_m * second
        self.longitudinal = step.decay * self.longitudinal + step.p_p * first


class Wind:
    """The air about the vehicle. A gust is held for GUST_STEP of flight, then the next follows.

    Its course depends on the seed and on the flight, not on how the flight is cut into steps.

    Args:
        mean: Mean velocity in ``map``, shape (3,), in [m/s].
        intensity: W20 in [m/s]; 0 for steady wind.
        seed: Of the gusts.
        heading: Horizontal direction of the air velocity at the start in [rad].
        height: Above ground at the start in [m].
    """

    def __init__(
        self,
        mean: ArrayLike,
        intensity: float,
        seed: np.random.SeedSequence,
        heading: float,
        height: float,
    ) -> None:
        self._random = np.random.default_rng(seed)
        u, v1, v2, w1, w2 = self._random.standard_normal(5).tolist()
        self._filters = GustFilter(u, 0.0), GustFilter(v1, v2), GustFilter(w1, w2)
        self._left = GUST_STEP  # of the present gust
        self._mean, self._velocity, self._intensity = np.zeros(3), np.zeros(3), 0.0
        self.change(mean, intensity, heading, height)

    def change(self, mean: ArrayLike, intensity: float, heading: float, height: float) -> None:
        """Blow otherwise from now on; the gust of now grows or shrinks with its strength.

        Args:
            mean: Mean velocity in ``map``, shape (3,), in [m/s].
            intensity: W20 in [m/s]; 0 for steady wind.
            heading: Horizontal direction of the air velocity now in [rad].
            height: Above ground now in [m].
        """
        same, before = intensity == self._intensity, self._mean
        self._mean, self._intensity = np.array(mean, dtype=float), intensity
        if same:  # also the gust of now
            self._velocity = self._velocity - before + self._mean
            return
        self._velocity = self._mean
        if intensity > 0.0:
            self._turn_to_map(heading, gust_scales(height, intensity))

    @property
    def velocity(self) -> NDArray[np.float64]:
        """Velocity of the air in ``map`` now, shape (3,), in [m/s]."""
        return self._velocity.copy()

    def advance(
        self, duration: float, airspeed: float, height: float, heading: float, turn: float
    ) -> NDArray[np.float64]:
        """Blow on.

        Args:
            duration: How long in [s].
            airspeed: V in [m/s].
            height: Above ground in [m].
            heading: Horizontal direction of the air velocity now in [rad].
            turn: By how much it turns over the duration in [rad].

        Returns:
            Displacement of the air, the integral of the velocity, shape (3,), in [m].
        """
        if self._intensity == 0.0:
            return self._mean * duration
        displacement, flown = np.zeros(3), 0.0
        while flown < duration:
            piece = min(duration - flown, self._left)
            displacement += self._velocity * piece
            flown += piece
            self._left -= piece
            if self._left <= 1e-9:  # s; sums of floats do not hit zero
                self._left += GUST_STEP
                scales = gust_scales(height, self._intensity)
                self._next_gust(airspeed * GUST_STEP, scales)
                self._turn_to_map(heading + turn * flown / duration, scales)
        return displacement

    def _next_gust(self, flown: float, scales: GustScales) -> None:
        u, v1, v2, w1, w2 = self._random.standard_normal(5).tolist()
        longitudinal, lateral, vertical = self._filters
        level = ExactStep(flown / scales.long)
        longitudinal.step(level, u, 0.0)
        lateral.step(level, v1, v2)
        vertical.step(ExactStep(flown / scales.short), w1, w2)

    def _turn_to_map(self, heading: float, scales: GustScales) -> None:
        longitudinal, lateral, vertical = self._filters
        forward, left = scales.level * longitudinal.longitudinal, scales.level * lateral.transverse
        sine, cosine = math.sin(heading), math.cos(heading)
        east, north = cosine * forward - sine * left, sine * forward + cosine * left
        up = scales.vertical * vertical.transverse
        self._velocity = self._mean + np.array([east, north, up])
