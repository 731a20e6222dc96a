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

r"""Measured angles and speeds, smoothed by their measured rates, whose biases are taken out.

A Kalman filter on :math:`x' = \dot x_{measured} - b` with a bias b that wanders slowly. How noisy x
is measured is seen (:mod:`~uav_tracking_mpc.estimation.noise_meter`), and until then as its source
tells: where there is no noise, nothing is smoothed.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.estimation.noise_meter import MEMORY, NoiseMeters, Signal
from uav_tracking_mpc.symbolic.functions import BufferedFunction

BIAS_WALK = 1e-3  # of the bias, variance per s as a share of that of the rate's noise
DEVIATIONS = 3.0  # of an innovation, that tells of the bias
LONGEST_GAP = 1.0  # s without a measurement, after which x begins anew
PARTS = 7  # of the state: x, b, the rate, its integral, and the covariance xx, xb, bb
VALUE, BIAS, RATE, P_XX, P_XB, P_BB = 0, 1, 2, 4, 5, 6


@dataclass(frozen=True)
class RateAided:
    """One quantity with its rate.

    Attributes:
        rate_noise: Of the measured rate, per root of Hz, in [1/s] of the unit.
        bias: Standard deviation of the rate's bias before it is known, in [1/s] of the unit.
        noise: Least standard deviation of the quantity that is believed, in its unit [SI].
        circular: Whether it is an angle in [rad] that wraps.
    """

    rate_noise: float
    bias: float
    noise: float
    circular: bool


class RateAidedFilters:
    """Quantities that are measured together.

    Args:
        quantities: What is filtered.
    """

    def __init__(self, quantities: Sequence[RateAided]) -> None:
        self._quantities, count = tuple(quantities), len(quantities)
        self._meters = _meters(self._quantities)
        self._state = np.zeros((PARTS, count))
        self._seen, self._elapsed = np.zeros((3, count)), np.zeros(1)
        meters, seen = (self._meters.state, self._meters.compared), (self._seen, self._elapsed)
        self._update = BufferedFunction(_function(self._quantities), [self._state, *meters, *seen])
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._time: float | None = None
        self._meters.reset()
        self._state[:] = 0.0
        self._state[P_BB] = np.square([quantity.bias for quantity in self._quantities])

    @property
    def values(self) -> NDArray[np.float64]:
        """Quantities at the newest measurement, shape (n,); angles are not wrapped."""
        return self._state[VALUE]

    @property
    def biases(self) -> NDArray[np.float64]:
        """Of the rates, shape (n,), in [1/s] of the units."""
        return self._state[BIAS]

    def update(self, time: float, measured: ArrayLike, rates: ArrayLike, told: ArrayLike) -> None:
        """Take in a measurement.

        Args:
            time: Of the measurement in [s].
            measured: The quantities, shape (n,), in their units [SI].
            rates: Their rates, shape (n,), in [1/s] of the units.
            told: Standard deviations of their noise by the source, shape (n,), in their units [SI];
                0 if unknown.
        """
        elapsed = math.inf if self._time is None else time - self._time
        self._time = time
        if not 0.0 <= elapsed <= LONGEST_GAP:
            least = [quantity.noise for quantity in self._quantities]
            self._state[VALUE], self._state[RATE] = measured, rates
            self._state[P_XX], self._state[P_XB] = np.square(np.maximum(told, least)), 0.0
            return
        self._seen[0], self._seen[1], self._seen[2] = measured, rates, told
        self._elapsed[0] = elapsed
        self._meters.begin(time)
        self._update.evaluate()
        state, self._meters.state[:], sample = self._update.results
        self._state[:] = state.reshape(self._state.shape)
        self._meters.keep(sample)


def _meters(quantities: tuple[RateAided, ...]) -> NoiseMeters:
    return NoiseMeters([Signal(1, quantity.noise) for quantity in quantities], MEMORY)


@functools.cache
def _function(quantities: tuple[RateAided, ...]) -> ca.Function:
    """An update: of state, meters' state, what they compare with, measurement and elapsed time."""
    count, meters = len(quantities), _meters(quantities)
    state, seen = ca.SX.sym("state", PARTS * count), ca.SX.sym("seen", 3 * count)
    known, compared = ca.SX.sym("m", len(meters.state)), ca.SX.sym("c", len(meters.compared))
    elapsed = ca.SX.sym("elapsed")
    value, bias, rate, integral, p_xx, p_xb, p_bb = ca.vertsplit(state, count)
    measured, new_rate, told = ca.vertsplit(seen, count)
    noise, rate_noise = (
        ca.DM([getattr(quantity, name) for quantity in quantities])
        for name in ("noise", "rate_noise")
    )
    advance = 0.5 * (rate + new_rate) * elapsed
    integral += advance
    value += advance - bias * elapsed
    spread = rate_noise**2 * elapsed
    p_xx += elapsed * (elapsed * p_bb - 2.0 * p_xb) + spread
    p_xb -= elapsed * p_bb
    p_bb += BIAS_WALK * spread
    innovation = measured - value
    for axis, quantity in enumerate(quantities):
        if quantity.circular:
            innovation[axis] = ca.remainder(innovation[axis], 2.0 * math.pi)
    sample = value + innovation - integral
    metered, variance = meters.metered(known, compared, sample, told**2)
    total = p_xx + ca.fmax(variance, noise**2)
    gain_x, gain_b = p_xx / total, p_xb / total
    most = DEVIATIONS * ca.sqrt(total)  # a jump is no bias of the rate
    steady = ca.fmax(-most, ca.fmin(innovation, most))
    after = ca.vertcat(
        value + gain_x * innovation,
        bias + gain_b * steady,
        new_rate,
        integral,
        p_xx - gain_x * p_xx,
        p_xb - gain_x * p_xb,
        p_bb - gain_b * p_xb,
    )
    arguments = [state, known, compared, seen, elapsed]
    return ca.Function("rate_aided", arguments, [after, metered, sample])
