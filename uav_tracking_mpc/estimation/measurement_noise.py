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

does not depend on where the target is and how fast. Its variance on each axis is
R_2 + (1 + rho)^2 R_1 + rho^2 R_0, and as long as the target hardly accelerates in h_0 + h_1 nothing
else is in it. With R = s R_told the factor s is a quantile of many squared second differences over
the variance that is told, divided by that of chi-square: turns on the spot, jumps and outliers are
rare and leave a quantile alone, and no filter that has lost the target misleads it.

Where heights scatter much more than places, as those of many trackers do, they tell nothing of R:
the second differences are then the horizontal ones alone.

Many of them make the factor accurate, few of them make it quick: the last few hundred count as long
as the newest agree with them, and the newest alone where they do not, for the noise has changed.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

WINDOW = 240  # second differences that count
NEWEST = 24  # of them, which notice that the noise has changed
CHANGED = 3.0  # ratio of the quantiles of newest and all: not by chance but once in a thousand
KNOWN = 3  # second differences after which the noise is known, with what is told
SPAN = 5.0  # s, within which the target's acceleration is taken as small
RATIO_MAX = 100.0  # -, of the intervals: an extrapolation any longer says little
QUANTILE = 0.4  # -, that is compared: with 20 % outliers half of the differences are wrong
CHI_SQUARE = 1.8691684  # -, that quantile, of 3 degrees of freedom
CHI_SQUARE_LEVEL = 1.0216512  # -, the same of 2
# -: noise of heights over that of places, from which on heights count by themselves; and the ratio
# of mean absolute values: of one normal number, and of the length of two
UNEVEN = 2.0
ABSOLUTES = math.sqrt(2.0 / math.pi) / math.sqrt(0.5 * math.pi)
SCALE_MIN, SCALE_MAX = 1e-12, 1e12  # -, of what is believed of a variance


class MeasurementNoise:
    """Factor between the variance of measured positions that is told and the true one.

    Attributes:
        scale: The factor, 1 before anything is known, [-].
        known: Whether enough has been measured for the factor to be more than a guess.
        uneven: Whether heights scatter much more than places. They do if what they change by goes
            up and down in turn; a target that climbs and sinks smoothly does not scatter.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Believe again what is told."""
        self._recent: deque[tuple[float, NDArray[np.float64], float]] = deque(maxlen=2)
        self._squares = deque([CHI_SQUARE], maxlen=WINDOW)
        self.scale, self.known, self.uneven = 1.0, False, False
        # -: averages of the length of horizontal second differences, of the size of vertical ones,
        # and of the product of two vertical ones in turn; and the last of these
        self._count, self._level, self._up, self._product, self._last = 0, 0.0, 0.0, 0.0, 0.0

    def see(self, time: float, position: NDArray[np.float64], variance: float) -> None:
        """Take in a position, whether or not a filter believes it.

        Args:
            time: When it was measured, after the one before, in [s].
            position: Shape (3,), in [m].
            variance: On each axis as it is told in [m^2].
        """
        recent = self._recent
        if len(recent) == 2:
            (t0, z0, r0), (t1, z1, r1) = recent
            if time - t0 <= SPAN and time - t1 <= RATIO_MAX * (t1 - t0):
                ratio = (time - t1) / (t1 - t0)
                difference = position - z1 - ratio * (z1 - z0)
                told = variance + (1.0 + ratio) ** 2 * r1 + ratio * ratio * r0
                self._compare(difference / math.sqrt(told))
                square = float(difference @ difference)
                if self.uneven:
                    square = CHI_SQUARE / CHI_SQUARE_LEVEL * (square - float(difference[2]) ** 2)
                self._add(square / told)
        recent.append((time, position, variance))

    def _compare(self, difference: NDArray[np.float64]) -> None:
        """Compare heights with places by a normalised second difference."""
        east, north, up = difference.tolist()
        self._count = min(self._count + 1, WINDOW)
        self._level += (math.hypot(east, north) - self._level) / self._count
        self._up += (abs(up) - self._up) / self._count
        self._product += (up * self._last - self._product) / self._count
        self._last = up
        large = self._up > UNEVEN * ABSOLUTES * self._level
        self.uneven = self._count >= NEWEST and large and self._product < 0.0

    def _add(self, square: float) -> None:
        self._squares.append(square)
        level = _quantile(self._squares)
        if len(self._squares) >= 2 * NEWEST:
            newest = list(self._squares)[-NEWEST:]
            recent = _quantile(newest)
            if not level <= CHANGED * recent <= CHANGED**2 * level:
                self._squares, level = deque(newest, maxlen=WINDOW), recent
        self.scale = min(max(level / CHI_SQUARE, SCALE_MIN), SCALE_MAX)
        self.known = len(self._squares) >= KNOWN


def _quantile(values: Iterable[float]) -> float:
    """As NumPy's, in a tenth of its time for so few values."""
    ordered = sorted(values)
    at = QUANTILE * (len(ordered) - 1)
    below = int(at)
    low, high = ordered[below], ordered[min(below + 1, len(ordered) - 1)]
    share = at - below
    return low + share * (high - low) if share < 0.5 else high - (1.0 - share) * (high - low)
