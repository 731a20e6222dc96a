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

"""Whether a ground velocity that nothing explains is the sensor's fault, or the air has changed."""

from __future__ import annotations

import math
from enum import Enum

import numpy as np
from numpy.typing import NDArray

ODD = 10.0  # m/s that a ground velocity may be apart from what is expected, besides deviations
DEVIATIONS = 4.0  # of what is expected, that it may be apart as well
WINDOW = 1.0  # s after which positions tell which of the two velocities was flown


class Velocity(Enum):
    """What to do with a measured ground velocity."""

    EXPECTED = "expected"
    ODD = "odd"  # not to be used
    NEW = "new"  # flown, though nothing explains it: what was expected is wrong


class VelocityCheck:
    """Compares measured ground velocities with expected ones, and both with the way flown."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget what was odd."""
        self._time = 0.0  # for which velocities have been odd, one after the other [s]
        self._begin = np.zeros(3)
        self._by_measured, self._by_expected = np.zeros(3), np.zeros(3)  # ways since then [m]

    def judge(
        self,
        elapsed: float,
        position: NDArray[np.float64],
        measured: NDArray[np.float64],
        expected: NDArray[np.float64],
        deviation: float,
    ) -> Velocity:
        """What to do with a velocity.

        Args:
            elapsed: Since the measurement before in [s].
            position: As measured, shape (3,), in [m].
            measured: Ground velocity, shape (3,), in [m/s].
            expected: The same as it was predicted, shape (3,), in [m/s].
            deviation: Standard deviation of the difference in [m/s].
        """
        east, north, up = (measured - expected).tolist()
        apart = math.sqrt(east * east + north * north + up * up)
        if apart <= ODD + DEVIATIONS * deviation:
            self._time = 0.0
            return Velocity.EXPECTED
        if self._time == 0.0:
            self._start(position)
        else:
            self._by_measured += elapsed * measured
            self._by_expected += elapsed * expected
        self._time += elapsed
        if self._time < WINDOW:
            return Velocity.ODD
        way = position - self._begin
        by_measured, by_expected = way - self._by_measured, way - self._by_expected
        if by_measured @ by_measured < by_expected @ by_expected:
            self.reset()
            return Velocity.NEW
        self._start(position)
        self._time = elapsed  # still odd; the next window decides anew
        return Velocity.ODD

    def _start(self, position: NDArray[np.float64]) -> None:
        self._begin[:] = position
        self._by_measured[:] = self._by_expected[:] = 0.0
