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

"""Notices a command that swings to and fro with one period: a loop at its limit of stability.

A command in gusts or after noise swings as well, but neither at one period nor with one amplitude.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import numpy as np

LEAST_AMPLITUDE = 0.05  # g across the path: 3 deg of bank
HALF_CYCLES = 9  # that must be alike: four periods and a half
SHORTEST, LONGEST = 0.3, 15.0  # s, of a period
PERIOD_SPREAD, AMPLITUDE_SPREAD = 0.12, 0.3  # standard deviation over mean, when it begins
ENDING = 2.0  # times these, or periods without a swing, when it ends
AVERAGING = 8.0  # s, time constant of the mean about which it swings
CROSSING = 0.3  # of the least amplitude, by which a swing must pass the mean


class Swing(NamedTuple):
    """A sustained oscillation.

    Attributes:
        period: In [s].
        amplitude: From the mean in [g].
    """

    period: float
    amplitude: float


class LimitCycleWatch:
    """Watches one signal, an acceleration across the path in [g].

    Attributes:
        swing: The oscillation; None while there is none.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget what was seen."""
        self.swing: Swing | None = None
        self._time: float | None = None
        self._mean, self._peak, self._side, self._turned = 0.0, 0.0, 0, 0.0
        self._halves: deque[tuple[float, float]] = deque(maxlen=HALF_CYCLES)

    def see(self, time: float, value: float) -> bool:
        """Take in a sample.

        Args:
            time: In [s].
            value: In [g].

        Returns:
            Whether an oscillation has begun or ended.
        """
        if self._time is None or not 0.0 <= time - self._time <= LONGEST:
            self.reset()
            self._time, self._mean = time, value
            return False
        share = -math.expm1(-(time - self._time) / AVERAGING)
        self._time = time
        self._mean += share * (value - self._mean)
        off = value - self._mean
        before = self.swing
        if off * self._side <= 0.0 and abs(off) > CROSSING * LEAST_AMPLITUDE:
            self._halves.append((time - self._turned, self._peak))
            self._side, self._turned, self._peak = (1 if off > 0.0 else -1), time, 0.0
            self.swing = self._judged()
        elif before is not None and time - self._turned > ENDING * before.period:
            self.swing = None
        self._peak = max(self._peak, abs(off))
        return (before is None) is not (self.swing is None)

    def _judged(self) -> Swing | None:
        """The oscillation that the last swings are, if they are one."""
        if len(self._halves) < HALF_CYCLES:
            return None
        halves, peaks = np.array(self._halves).T
        periods = halves[:-1] + halves[1:]
        period, amplitude = float(np.mean(periods)), float(np.mean(peaks))
        slack = 1.0 if self.swing is None else ENDING
        alike = (
            np.std(periods) <= slack * PERIOD_SPREAD * period
            and np.std(peaks) <= slack * AMPLITUDE_SPREAD * amplitude
        )
        strong = amplitude * slack >= LEAST_AMPLITUDE
        if alike and strong and SHORTEST <= period <= LONGEST:
            return Swing(period, amplitude)
        return None
