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

r"""What a fit leaves over, as autoregressive noise, and the filter that makes it white.

Sensor noise is white; gusts, and whatever else the model does not describe, are not. Least squares
on residuals made white by :math:`A(q) e` is maximum likelihood for both, and its intervals hold
(L. Ljung, System Identification, 2nd ed., 1999, sections 7.4 and 10.3). Commands answer to
measured noise; with the noise described, that does not bias the fit (section 13.4).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.signal import lfilter

ORDERS = (0, 1, 2, 4, 8, 16)  # tried; samples


class NoiseModel(NamedTuple):
    """Autoregressive noise.

    Attributes:
        polynomial: A(q), from 1 on, shape (p + 1,).
        deviation: Of the white noise behind it, in [rad], [rad/s] or [m/s] as the residuals.
    """

    polynomial: NDArray[np.float64]
    deviation: float

    def whitened(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values filtered and scaled to noise of unit variance, without the first p ones.

        Args:
            values: Along the first axis, shape (n,) or (n, k).

        Returns:
            Shape (n - p,) or (n - p, k).
        """
        order = len(self.polynomial) - 1
        return lfilter(self.polynomial, [1.0], values, axis=0)[order:] / self.deviation


def noise_of(residuals: NDArray[np.float64], least: float) -> NoiseModel:
    """The noise that explains residuals best, by the Bayesian information criterion.

    Args:
        residuals: Of zero mean, shape (n,).
        least: Deviation that is assumed at least, in [rad], [rad/s] or [m/s]: no sensor is exact.
    """
    count = len(residuals)
    covariance = np.array(
        [residuals[lag:] @ residuals[: count - lag] / count for lag in range(ORDERS[-1] + 1)]
    )
    if covariance[0] <= least**2:
        return NoiseModel(np.ones(1), least)
    best, chosen = np.inf, NoiseModel(np.ones(1), 1.0)
    for order in ORDERS:
        polynomial, variance = np.ones(1), covariance[0]
        if order:
            weights = solve_toeplitz(covariance[:order], covariance[1 : order + 1])
            polynomial = np.concatenate([[1.0], -weights])
            variance = covariance[0] - weights @ covariance[1 : order + 1]
        variance = max(variance, least**2)
        criterion = count * np.log(variance) + order * np.log(count)
        if criterion < best:
            best, chosen = criterion, NoiseModel(polynomial, float(np.sqrt(variance)))
    return chosen
