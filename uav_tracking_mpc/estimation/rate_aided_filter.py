r"""A measured angle or speed, smoothed by its measured rate, whose constant bias is taken out.

A Kalman filter on :math:`x' = \dot x_{measured} - b` with a bias b that wanders slowly. How noisy x
is measured is not told but seen (:mod:`~uav_tracking_mpc.estimation.noise_meter`): where there is
no noise, nothing is smoothed.
"""

from __future__ import annotations

import math

import numpy as np

from uav_tracking_mpc.estimation.noise_meter import MEMORY, NoiseMeter

BIAS_WALK = 1e-3  # of the bias, variance per s as a share of that of the rate's noise
LONGEST_GAP = 1.0  # s without a measurement, after which x begins anew


class RateAidedFilter:
    """One quantity with its rate.

    Args:
        rate_noise: Of the measured rate, per root of Hz, in [1/s] of the unit.
        bias: Standard deviation of the rate's bias before it is known, in [1/s] of the unit.
        noise: Least standard deviation of the quantity that is believed, in its unit [SI].
        circular: Whether it is an angle in [rad] that wraps.

    Attributes:
        value: The quantity at the newest measurement, in its unit [SI]; an angle is not wrapped.
        bias: Of the rate, in [1/s] of the unit.
    """

    def __init__(self, rate_noise: float, bias: float, noise: float, circular: bool) -> None:
        self._rate_noise, self._prior, self._noise = rate_noise, bias, noise
        self._circular = circular
        self._meter = NoiseMeter(noise, MEMORY)
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._time: float | None = None
        self._meter.reset()
        self.value = self.bias = self._rate = self._integral = 0.0
        self._p_xx, self._p_xb, self._p_bb = 0.0, 0.0, self._prior**2

    def update(self, time: float, measured: float, rate: float) -> None:
        """Take in a measurement.

        Args:
            time: Of the measurement in [s].
            measured: The quantity in its unit [SI].
            rate: Its rate in [1/s] of the unit.
        """
        elapsed = math.inf if self._time is None else time - self._time
        self._time = time
        if not 0.0 <= elapsed <= LONGEST_GAP:
            self.value, self._p_xx, self._p_xb = measured, self._noise**2, 0.0
            self._rate = rate
            return
        advance = 0.5 * (self._rate + rate) * elapsed
        self._rate = rate
        self._integral += advance
        self.value += advance - self.bias * elapsed
        spread = self._rate_noise**2 * elapsed
        self._p_xx += elapsed * (elapsed * self._p_bb - 2.0 * self._p_xb) + spread
        self._p_xb -= elapsed * self._p_bb
        self._p_bb += BIAS_WALK * spread
        innovation = measured - self.value
        if self._circular:
            innovation = math.remainder(innovation, 2.0 * math.pi)
        self._meter.see(time, np.array([self.value + innovation - self._integral]))
        variance = self._p_xx + max(self._meter.variance, self._noise**2)
        gain_x, gain_b = self._p_xx / variance, self._p_xb / variance
        self.value += gain_x * innovation
        self.bias += gain_b * innovation
        self._p_bb -= gain_b * self._p_xb
        self._p_xb -= gain_x * self._p_xb
        self._p_xx -= gain_x * self._p_xx
