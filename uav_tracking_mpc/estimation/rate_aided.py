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
tells: where there is no noise, nothing is smoothed. These are expressions:
:mod:`~uav_tracking_mpc.estimation.air_estimate` compiles them.
"""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.motion_check import DEVIATIONS
from uav_tracking_mpc.estimation.noise_meter import NoiseMeters
from uav_tracking_mpc.symbolic.layout import Layout

# Of heading and path angle, whose rates are measured, and airspeed, whose rate is that of the
# commands: noise of the rate per root of Hz and standard deviation of its bias, in [rad/s] and
# [m/s^2]; least standard deviation that is believed, in [rad] and [m/s].
RATE_NOISE = np.array([1e-3, 1e-3, 0.1])
RATE_BIAS = np.array([0.05, 0.05, 0.5])
LEAST_NOISE = np.array([1e-3, 1e-3, 0.05])
ANGLES = 2  # of the quantities, the first ones, wrap
BIAS_WALK = 1e-3  # of the bias, variance per s as a share of that of the rate's noise
# rad^2/s^3 of a rate that nobody tells, and so is exactly 0: it is what the bias is then for
UNTOLD_WALK = np.array([0.001, 0.001, 0.0])
METERS = NoiseMeters((1, 1, 1), LEAST_NOISE.tolist(), (0.0, 0.0, 0.0))
RATE_AIDED = Layout(
    value=3, bias=3, rate=3, integral=3, xx=3, xb=3, bb=np.square(RATE_BIAS), meters=METERS.layout
)


def begin_values(
    known: SimpleNamespace,
    measured: NDArray[np.float64],
    rates: NDArray[np.float64],
    told: NDArray[np.float64],
) -> None:
    """Let the quantities begin anew at what is measured; the biases stay.

    Args:
        known: Views by :data:`RATE_AIDED`.
        measured: Shape (3,), in [rad] and [m/s].
        rates: Shape (3,), in [rad/s] and [m/s^2].
        told: Standard deviations of the noise by the source, shape (3,); 0 where unknown.
    """
    known.value[:], known.rate[:] = measured, rates
    known.xx[:], known.xb[:] = np.square(np.maximum(told, LEAST_NOISE)), 0.0


def smoothed(
    known: SimpleNamespace,
    elapsed: ca.SX,
    measured: ca.SX,
    rates: ca.SX,
    told: ca.SX,
    biased: ca.SX,
) -> SimpleNamespace:
    """What is known after a measurement, by :data:`RATE_AIDED`; angles are not wrapped.

    Args:
        known: Before, by :data:`RATE_AIDED`.
        elapsed: Since the measurement before in [s].
        measured: Heading, path angle [rad] and airspeed [m/s], shape (3,).
        rates: Of these, shape (3,).
        told: Standard deviations of their noise by the source, shape (3,); 0 where unknown.
        biased: Whether the rates may have a bias, shape (3,): those of a sensor do.
    """
    advance = 0.5 * (known.rate + rates) * elapsed
    integral = known.integral + advance
    bias, xb, bb = (biased * each for each in (known.bias, known.xb, known.bb))
    value = known.value + advance - bias * elapsed
    spread = ca.DM(RATE_NOISE) ** 2 * elapsed
    xx = known.xx + elapsed * (elapsed * bb - 2.0 * xb) + spread
    xb = xb - elapsed * bb
    untold = (rates == 0.0) * ca.DM(UNTOLD_WALK)
    bb = bb + BIAS_WALK * spread + biased * untold * elapsed
    innovation = measured - value
    innovation[:ANGLES] = ca.remainder(innovation[:ANGLES], math.tau)
    sample = value + innovation - integral
    meters = METERS.metered(known.meters, elapsed, sample, told**2)
    total = xx + ca.fmax(meters.held, ca.DM(LEAST_NOISE) ** 2)
    gain_x, gain_b = xx / total, xb / total
    most = DEVIATIONS * ca.sqrt(total)  # a jump is no bias of the rate
    bias += gain_b * ca.fmax(-most, ca.fmin(innovation, most))
    return SimpleNamespace(
        value=value + gain_x * innovation,
        bias=ca.if_else(biased, bias, known.bias),  # a gyro keeps it while the bank tells the turn
        rate=rates,
        integral=integral,
        xx=xx - gain_x * xx,
        xb=xb - gain_x * xb,
        bb=ca.if_else(biased, bb - gain_b * xb, known.bb),
        meters=meters,
    )
