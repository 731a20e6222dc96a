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

r"""How noisy measured positions are, from the positions alone.

The second difference of three positions z at intervals h_0 and h_1,

.. math:: d = z_2 - z_1 - \rho (z_1 - z_0), \quad \rho = h_1 / h_0

does not depend on where the target is and how fast. Its variance on an axis is
R_2 + (1 + rho)^2 R_1 + rho^2 R_0, and as long as the target hardly accelerates in h_0 + h_1 nothing
else is in it. With R = s R_told the factor s is a quantile of many squared second differences over
the variance that is told, divided by that of chi-square: turns on the spot, jumps and outliers are
rare and leave a quantile alone, and no filter that has lost the target misleads it.

Where the axes differ much, as the height and the distance of many trackers do from the rest, each
has a share of s of its own, from the same quantile of its own squares. That takes more of them.

Many of them make the factor accurate, few of them make it quick: the last few hundred count as long
as the newest agree with them, and the newest alone where they do not, for the noise has changed.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

WINDOW = 240  # second differences that count
NEWEST = 24  # of them, which notice that the noise has changed
CHANGED = 3.0  # ratio of the quantiles of newest and all: not by chance but once in a thousand
COMPARED = 96  # of them, by which axes are compared: noise of a camera turns with where it looks
KNOWN = 3  # second differences after which the noise is known, with what is told
SPAN = 5.0  # s, within which the target's acceleration is taken as small
RATIO_MAX = 100.0  # -, of the intervals: an extrapolation any longer says little
QUANTILE = 0.4  # -, that is compared: with 20 % outliers half of the differences are wrong
CHI_SQUARE = 1.8691684  # -, that quantile, of 3 degrees of freedom
CHI_SQUARE_AXIS = 0.2749959  # -, the same of 1
# -: greatest variance over the least, from which on axes have shares of their own (by chance once
# in a thousand), and still have; and the least share, that of an axis without noise
UNEVEN, EVEN, SHARE_MIN = 4.0, 2.0, 1e-6
SCALE_MIN, SCALE_MAX = 1e-12, 1e12  # -, of what is believed of a variance


class MeasurementNoise:
    """Factors between the variances of measured positions that are told and the true ones.

    Attributes:
        scales: The factor of each axis, 1 before anything is known, shape (3,), [-].
        known: Whether enough has been measured for the factors to be more than a guess.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Believe again what is told."""
        self._recent: deque[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = deque(
            maxlen=2
        )
        # -: second differences by what is told on each axis, sums of their squares by the shares
        self._axes: deque[list[float]] = deque(maxlen=WINDOW)
        self._squares = deque([CHI_SQUARE], maxlen=WINDOW)
        # -: variance of each axis over what is told, and the quantile of the sums that goes with it
        self._shares, self._usual, self._count = [1.0, 1.0, 1.0], CHI_SQUARE, 0
        self._uneven = False
        self.scales, self.known = np.ones(3), False

    def see(
        self, time: float, position: NDArray[np.float64], variances: NDArray[np.float64]
    ) -> None:
        """Take in a position, whether or not a filter believes it.

        Args:
            time: When it was measured, after the one before, in [s].
            position: Shape (3,), in [m].
            variances: On each axis as they are told, shape (3,), in [m^2].
        """
        recent = self._recent
        if len(recent) == 2:
            (t0, z0, r0), (t1, z1, r1) = recent
            if time - t0 <= SPAN and time - t1 <= RATIO_MAX * (t1 - t0):
                ratio = (time - t1) / (t1 - t0)
                difference = position - z1 - ratio * (z1 - z0)
                told = variances + (1.0 + ratio) ** 2 * r1 + ratio * ratio * r0
                self._add((difference / np.sqrt(told)).tolist())
        recent.append((time, position, variances))

    def _add(self, differences: list[float]) -> None:
        self._axes.append(differences)
        self._squares.append(self._sum(differences))
        self._count += 1
        if self._count % NEWEST == 0 and len(self._axes) >= COMPARED:
            self._share()
        level = _quantile(self._squares)
        if len(self._squares) >= 2 * NEWEST:
            newest = list(self._squares)[-NEWEST:]
            recent = _quantile(newest)
            if not level <= CHANGED * recent <= CHANGED**2 * level:
                self._squares, level = deque(newest, maxlen=WINDOW), recent
                self._axes = deque(list(self._axes)[-NEWEST:], maxlen=WINDOW)
        scales = level / self._usual * np.array(self._shares)
        self.scales = np.clip(scales, SCALE_MIN, SCALE_MAX)
        self.known = len(self._squares) >= KNOWN

    def _sum(self, differences: list[float]) -> float:
        return sum(d * d / share for d, share in zip(differences, self._shares, strict=True))

    def _share(self) -> None:
        """Compare the axes; noise goes up and down in turn, as no way of a target does."""
        axes = list(zip(*list(self._axes)[-COMPARED:], strict=True))
        own = [_quantile(d * d for d in axis) / CHI_SQUARE_AXIS for axis in axes]
        most, noisiest = max(own), axes[own.index(max(own))]
        uneven = most > (EVEN if self._uneven else UNEVEN) * min(own)
        uneven = uneven and sum(one * other for one, other in pairwise(noisiest)) < 0.0
        if uneven or self._uneven:
            least = max(SHARE_MIN * most, SCALE_MIN)
            self._shares = [max(each, least) if uneven else 1.0 for each in own]
            self._axes = deque(list(self._axes)[-COMPARED:], maxlen=WINDOW)
            self._squares = deque(map(self._sum, self._axes), maxlen=WINDOW)
            self._usual = _quantile(self._squares) if uneven else CHI_SQUARE
        self._uneven = uneven


def _quantile(values: Iterable[float]) -> float:
    """As NumPy's, in a tenth of its time for so few values."""
    ordered = sorted(values)
    at = QUANTILE * (len(ordered) - 1)
    below = int(at)
    low, high = ordered[below], ordered[min(below + 1, len(ordered) - 1)]
    share = at - below
    return low + share * (high - low) if share < 0.5 else high - (1.0 - share) * (high - low)
