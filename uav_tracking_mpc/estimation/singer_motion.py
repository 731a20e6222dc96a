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

r"""How a target moves whose acceleration is random: Singer's model.

R. A. Singer, "Estimating Optimal Tracking Filter Performance for Manned Maneuvering Targets",
IEEE Trans. Aerospace and Electronic Systems 6(4), 1970: on each axis p' = v, v' = a and

.. math:: a' = -a / \tau + w, \quad E[w(t) w(s)] = (2 \sigma_a^2 / \tau)\, \delta(t - s)

so that the acceleration has standard deviation sigma_a and is forgotten after tau.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

MANOEUVRE_TIME = 5.0  # s, tau: least prediction errors on circles, straight runs, stop and go
# s without a position after which the velocity fades; of a target that has run straight on
BRIDGE_TIME, STRAIGHT_TIME = 5.0, 30.0
FADE_TIME = 10.0  # s, its time constant
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


def bridged(age: float, held: float = BRIDGE_TIME) -> tuple[float, float]:
    """Time travelled at the velocity last known, and the share of it that is left.

    A target that is lost is taken to run on for a while and then to slow down, so that no
    position runs away.

    Args:
        age: Of the newest measurement in [s].
        held: Time for which it is taken to run on in [s].

    Returns:
        Time in [s], and the share, from 0 to 1.
    """
    if age <= held:
        return age, 1.0
    left = math.exp(-(age - held) / FADE_TIME)
    return held + FADE_TIME * (1.0 - left), left
