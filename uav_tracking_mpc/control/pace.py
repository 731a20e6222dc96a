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

"""When a command is due: states come at their own rate, commands keep theirs on the average."""

from __future__ import annotations

FORGIVEN = 0.01  # of the period by which a state may be early: rounding must not cost a whole state


class Pace:
    """Picks the states from which a command is computed.

    Args:
        rate: Commands per second wanted in [Hz]; no more can come than there are states.
    """

    def __init__(self, rate: float) -> None:
        self.period = 1.0 / rate
        self._due: float | None = None  # when the latest command was

    def due(self, stamp: float) -> bool:
        """Whether the state of this stamp is the one to answer.

        Lost time is not made up for: after a gap, and where time went back, the pace starts anew.

        Args:
            stamp: In [s].
        """
        if self._due is None or stamp < self._due - self.period:
            self._due = stamp
            return True
        due = self._due + self.period
        if stamp < due - FORGIVEN * self.period:
            return False
        self._due = stamp if due + self.period <= stamp else due
        return True
