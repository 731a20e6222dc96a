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

"""ROS time by another clock of this machine, without the noise of reading two clocks in turn."""

from __future__ import annotations

from collections.abc import Callable

SHARE = 0.02  # of a new reading in the offset
STEP = 5e-3  # s by which a reading may differ before the clocks count as set anew
WITNESSES = 3  # readings in a row that say so: one may lie where the process was interrupted


class ClockOffset:
    """Offset of ROS time to the clock of a vehicle link.

    Args:
        ros: Reads ROS time in [ns].
        other: Reads the other clock in [s].
    """

    def __init__(self, ros: Callable[[], int], other: Callable[[], float]) -> None:
        self._ros, self._other = ros, other
        self._offset: int | None = None
        self._doubts = 0

    def read(self) -> int:
        """ROS time minus the other clock in [ns], read anew and averaged."""
        before = self._other()
        ros = self._ros()
        now = ros - round(0.5e9 * (before + self._other()))
        if self._offset is None:
            self._offset = now
        off = now - self._offset
        self._doubts = self._doubts + 1 if abs(off) > STEP * 1e9 else 0
        if self._doubts >= WITNESSES:
            self._offset, self._doubts = now, 0
        elif not self._doubts:
            self._offset += round(SHARE * off)
        return self._offset

    def ros(self, time: float) -> int:
        """ROS time in [ns] of a time of the other clock.

        Args:
            time: Of the other clock in [s].
        """
        return round(time * 1e9) + self.read()

    def other(self, stamp: int) -> float:
        """The other clock's time in [s] of a ROS time.

        Args:
            stamp: ROS time in [ns].
        """
        return (stamp - (self.read() if self._offset is None else self._offset)) * 1e-9
