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

"""Whether this process was stopped: messages queued meanwhile are discarded."""

from __future__ import annotations

DRAIN = 0.1  # s after a stop in which the queued messages arrive


class StallGuard:
    """Notices by the wall clock that the process was stopped or starved.

    Messages that came meanwhile are delivered one after the other, oldest first. In simulated time
    nothing in them tells their age, for time itself is a message.

    Args:
        limit: Time without a call of :meth:`alive` that counts as a stop, in [s]; longer than
            the period of whatever calls it regularly.

    Attributes:
        stalls: How often the process was stopped.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._last: float | None = None
        self._until = -float("inf")
        self.stalls = 0

    def alive(self, now: float) -> bool:
        """Note that the process runs.

        Args:
            now: Time of the steady clock in [s].

        Returns:
            Whether a message that arrives now is new.
        """
        if self._last is not None and now - self._last > self._limit:
            self._until = now + DRAIN
            self.stalls += 1
        self._last = now
        return now >= self._until
