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

"""Which status is shown where it may change with every message: a worse one at once.

A better one, or another as bad, is shown when the present one has not been reported for some
seconds, or had itself stood that long: what alternates twenty times a second is shown as its worse
half, and a state of affairs that lasted ends at once.
"""

from __future__ import annotations

LASTING = 2.0  # s
FINE, WARN = b"\x00", b"\x01"  # levels of diagnostic_msgs


class SteadyStatus:
    """The status of a node.

    Until it was fine or erroneous for the first time every change is shown at once.

    Args:
        level: At the start, as of diagnostic_msgs.
        message: For people.

    Attributes:
        level: That is shown.
        message: That is shown.
        starting: Whether it has been neither fine nor erroneous yet.
    """

    def __init__(self, level: bytes, message: str) -> None:
        self.begin(level, message)

    def begin(self, level: bytes, message: str) -> None:
        """Show a status at once and begin anew.

        Args:
            level: As of diagnostic_msgs.
            message: For people.
        """
        self.level, self.message = level, message
        self.starting = level == WARN
        self._since = self._seen = -float("inf")
        self._alone = True  # whether nothing else was reported since it is shown

    def see(self, level: bytes, message: str, now: float) -> bool:
        """Take in how the node is.

        Args:
            level: As of diagnostic_msgs.
            message: For people.
            now: Time of a steady clock in [s].

        Returns:
            Whether another status is shown than before.
        """
        if (level, message) == (self.level, self.message):
            if not self._alone:
                self._alone, self._since = True, now
            self._seen = now
            return False
        ended = now - self._seen >= LASTING or (self._alone and now - self._since >= LASTING)
        self._alone = False
        if not (self.starting or level > self.level or level == self.level == FINE or ended):
            return False
        self.level, self.message = level, message
        self._since, self._seen, self._alone = now, now, True
        self.starting = self.starting and level == WARN
        return True
