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

r"""Stability margins of a sampled loop with three inputs, from its frequency response.

The loop is broken at the plant's input. :math:`L(e^{i\omega T})` is the return ratio there, of
negative feedback, :math:`S = (I + L)^{-1}` and :math:`T = I - S`. With all other loops closed, that
of channel i is

.. math:: l_i = 1 / S_{ii} - 1.

Gain, phase and delay margins are those of :math:`l_i`. The disk margin :math:`\alpha` is symmetric
(skew 0): the loop stays stable under every simultaneous change of gain and phase
:math:`(1 + \delta/2) / (1 - \delta/2)` with complex :math:`|\delta| < \alpha`, one :math:`\delta`
for a channel or one for each of all channels at once,

.. math:: 1 / \alpha = \sup_\omega \mu\bigl((S - T) / 2\bigr)

(Seiler, Packard, Gahinet, "An introduction to disk margins", IEEE Control Systems Magazine 40(5),
2020). For three complex scalars the structured singular value :math:`\mu` equals its upper bound
:math:`\min_D \bar\sigma(D M D^{-1})` over positive diagonal D (Packard, Doyle, "The complex
structured singular value", Automatica 29(1), 1993), and that minimum is convex in log D.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

CHANNELS = ("turn", "path", "speed")
BALANCING_SWEEPS = 20  # iterations of Osborne's, after which the bound hardly changes


class ChannelMargins(NamedTuple):
    """How far one channel is from instability, all others as they are.

    Attributes:
        gain_db: Least change of the gain, up or down, in [dB]; infinite if none.
        gain_increase_db: By which the gain may grow in [dB].
        gain_reduction_db: By which the gain may shrink in [dB].
        phase_deg: Least additional phase of either sign in [deg].
        delay_s: Least additional delay in [s].
        crossover_rad_s: Frequency in [rad/s] at which that delay brings the loop to its limit; nan
            where no delay does.
        disk: alpha [-].
    """

    gain_db: float
    gain_increase_db: float
    gain_reduction_db: float
    phase_deg: float
    delay_s: float
    crossover_rad_s: float
    disk: float


class LoopMargins(NamedTuple):
    """Margins of a loop.

    Attributes:
        channels: By name, see :data:`CHANNELS`.
        disk: alpha [-] of all channels at once.
    """

    channels: dict[str, ChannelMargins]
    disk: float


_NONE = ChannelMargins(0.0, 0.0, 0.0, 0.0, 0.0, math.nan, 0.0)
UNSTABLE = LoopMargins(dict.fromkeys(CHANNELS, _NONE), 0.0)  # of a loop that is not stable


def loop_margins(frequency: NDArray[np.float64], loop: NDArray[Any]) -> LoopMargins:
    """Margins of a loop that is stable when closed.

    Args:
        frequency: Increasing, shape (n,), in [rad/s].
        loop: L, shape (n, 3, 3).
    """
    ratios = return_ratios(loop).T
    channels = {
        name: channel_margins(frequency, ratio)
        for name, ratio in zip(CHANNELS, ratios, strict=True)
    }
    sensitivity = np.linalg.inv(np.eye(3) + loop)
    return LoopMargins(channels, 1.0 / _greatest_mu(sensitivity - 0.5 * np.eye(3)))


def return_ratios(loop: NDArray[Any]) -> NDArray[Any]:
    """l_i of each channel with all other loops closed, shape (n, 3).

    Args:
        loop: L, shape (n, 3, 3).
    """
    sensitivity = np.linalg.inv(np.eye(3) + loop)
    return 1.0 / np.einsum("nii->ni", sensitivity) - 1.0


def channel_margins(frequency: NDArray[np.float64], ratio: NDArray[Any]) -> ChannelMargins:
    """Margins of one return ratio whose loop is stable when closed.

    Args:
        frequency: Increasing, shape (n,), in [rad/s].
        ratio: l, shape (n,).
    """
    up, down = _gain_margins(ratio)
    phase, delay, crossover = _phase_margins(frequency, ratio)
    disk = 1.0 / float(np.max(np.abs(1.0 / (1.0 + ratio) - 0.5)))
    return ChannelMargins(min(up, down), up, down, phase, delay, crossover, disk)


def disk_gain_db(disk: float) -> float:
    """Change of gain, up and down, inside a disk margin in [dB].

    Args:
        disk: alpha [-].
    """
    return 20.0 * math.log10((2.0 + disk) / (2.0 - disk)) if disk < 2.0 else math.inf


def disk_phase_deg(disk: float) -> float:
    """Change of phase, either sign, inside a disk margin in [deg].

    Args:
        disk: alpha [-].
    """
    return math.degrees(2.0 * math.atan(0.5 * disk))


def _gain_margins(ratio: NDArray[Any]) -> tuple[float, float]:
    """Increase and reduction in [dB] at which the ratio passes through -1."""
    real, imaginary = ratio.real, ratio.imag
    crossing = np.flatnonzero(imaginary[:-1] * imaginary[1:] <= 0.0)
    step = imaginary[crossing + 1] - imaginary[crossing]
    share = np.where(step == 0.0, 0.0, -imaginary[crossing] / np.where(step == 0.0, 1.0, step))
    at = real[crossing] + share * (real[crossing + 1] - real[crossing])
    at = np.append(at, real[-1])  # at the Nyquist frequency a sampled ratio is real
    decibels = -20.0 * np.log10(-at[at < 0.0])
    increase = float(np.min(decibels[decibels > 0.0], initial=math.inf))
    return increase, float(np.min(-decibels[decibels <= 0.0], initial=math.inf))


def _phase_margins(
    frequency: NDArray[np.float64], ratio: NDArray[Any]
) -> tuple[float, float, float]:
    """Phase in [deg], delay in [s] and its frequency in [rad/s] that bring the ratio to -1."""
    size = np.log(np.abs(ratio))
    crossing = np.flatnonzero(size[:-1] * size[1:] < 0.0)
    if not len(crossing):
        return math.inf, math.inf, math.nan
    share = size[crossing] / (size[crossing] - size[crossing + 1])
    angle = np.unwrap(np.angle(ratio))
    at = angle[crossing] + share * (angle[crossing + 1] - angle[crossing])
    omega = frequency[crossing] * (frequency[crossing + 1] / frequency[crossing]) ** share
    lag = np.mod(at + math.pi, 2.0 * math.pi)  # additional lag that leads to -1
    delays = lag / omega
    first = int(np.argmin(delays))
    phase = np.minimum(lag, 2.0 * math.pi - lag)
    return math.degrees(float(np.min(phase))), float(delays[first]), float(omega[first])


def _greatest_mu(matrices: NDArray[Any]) -> float:
    """Greatest structured singular value of any of the matrices, shape (n, 3, 3)."""
    scaled = matrices.copy()
    scales = np.zeros(matrices.shape[:2])  # log D
    for _ in range(BALANCING_SWEEPS):
        for axis in range(3):
            others = [other for other in range(3) if other != axis]
            row = np.linalg.norm(scaled[:, axis, others], axis=1) + 1e-300
            column = np.linalg.norm(scaled[:, others, axis], axis=1) + 1e-300
            scale = np.clip(np.sqrt(column / row), 1e-6, 1e6)
            scaled[:, axis, :] *= scale[:, np.newaxis]
            scaled[:, :, axis] /= scale[:, np.newaxis]
            scales[:, axis] += np.log(scale)
    bounds = np.linalg.norm(scaled, 2, axis=(1, 2))
    greatest = 0.0
    for index in np.argsort(-bounds):
        if bounds[index] <= greatest:
            break
        greatest = max(greatest, _mu(matrices[index], scales[index]))
    return greatest


def _mu(matrix: NDArray[Any], start: NDArray[np.float64]) -> float:
    """Structured singular value of a matrix, by D scales from ``start`` on, shape (3,)."""

    def bound(logarithms: NDArray[np.float64]) -> float:
        scale = np.exp(np.append(logarithms, 0.0))
        return float(np.linalg.norm(scale[:, np.newaxis] * matrix / scale, 2))

    from scipy.optimize import minimize  # a third of what a node would import before it flies

    found = minimize(bound, start[:2] - start[2], method="Nelder-Mead", options={"xatol": 1e-4})
    return float(found.fun)
