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

"""The time at which a recorded flight is shown: it plays, stands, and goes where it is sent."""

from __future__ import annotations

import time
from collections.abc import Callable

RATES = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)


class PlayClock:
    """Time between the begin and the end of a record.

    Args:
        begin: First time in [s].
        end: Last time in [s].
        now: Steady wall time in [s].

    Attributes:
        begin: First time in [s].
        end: Last time in [s].
    """

    def __init__(self, begin: float, end: float, now: Callable[[], float] = time.monotonic) -> None:
        self.begin, self.end, self._now = begin, end, now
        self._from, self._since = begin, now()
        self._rate, self._playing = 1.0, True

    @property
    def time(self) -> float:
        """Where the record stands in [s]."""
        if not self._playing:
            return self._from
        return min(self._from + self._rate * (self._now() - self._since), self.end)

    @property
    def playing(self) -> bool:
        """Whether it goes on; it stands at the end."""
        return self._playing and self.time < self.end

    @property
    def rate(self) -> float:
        """Recorded over wall time [-]."""
        return self._rate

    @rate.setter
    def rate(self, rate: float) -> None:
        """Play at another rate from now on [-]."""
        self.seek(self.time)
        self._rate = rate

    def seek(self, time: float) -> None:
        """Go to a time; it plays on from there if it played.

        Args:
            time: In [s]; the nearest one of the record is taken.
        """
        self._from, self._since = min(max(time, self.begin), self.end), self._now()

    def play(self, rate: float | None = None) -> None:
        """Go on, from the begin where it stood at the end.

        Args:
            rate: Recorded over wall time [-], positive; unchanged by default.
        """
        at_end = self.time >= self.end
        self.seek(self.begin if at_end and not self.playing else self.time)
        self._playing = True
        self._rate = self._rate if rate is None else rate

    def pause(self) -> None:
        """Stand still."""
        self.seek(self.time)
        self._playing = False
