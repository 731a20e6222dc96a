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

r"""The autopilot's clock by ours, from round trips of TIMESYNC (MAVLink guide, Timesync).

We send our time :math:`t_1`, the autopilot answers with its own :math:`t_a`, the answer arrives at
:math:`t_2`. Its clock is then ours plus :math:`t_a - (t_1 + t_2)/2`, wrong by at most half the
round trip. The quickest of the last round trips counts: queues only ever add to them (Mills, RFC
5905, Section 10). Until the first answer the least delay of telemetry counts: the stamp of a
message is at most now.
"""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

KEPT = 20  # round trips
LONGEST = 1.0  # s of a round trip that tells anything
AHEAD = 1.0  # s by which a stamp may lie in the future before its clock is doubted
BACK = 1.0  # s by which a stamp may lie before the newest one before its clock is doubted
WITNESSES = 3  # stamps or answers that must doubt the clock alike: one may be an old repeat


class RoundTrip(NamedTuple):
    """One exchange.

    Attributes:
        offset: Autopilot's time minus ours in [s].
        duration: Of the round trip in [s].
    """

    offset: float
    duration: float


class AutopilotClock:
    """Offset of the autopilot's time since its boot to our clock.

    Attributes:
        offset: Autopilot's time minus ours in [s]; None while nothing is known.
        jitter: Standard deviation of the round trips' offsets in [s]; 0 while there are too few.
        delay: Half of the quickest round trip in [s]; 0 while there is none.
        restarts: How often the clock was started anew.
    """

    def __init__(self) -> None:
        self.restarts = 0
        self.forget()

    def forget(self) -> None:
        """Begin anew: the autopilot has restarted."""
        self._trips: deque[RoundTrip] = deque(maxlen=KEPT)
        self._doubts: list[float] = []
        self._strays: list[RoundTrip] = []
        self._newest = -math.inf
        self.offset: float | None = None
        self.jitter = self.delay = 0.0

    def see_stamp(self, stamp: float, arrival: float) -> None:
        """Take in the stamp of telemetry.

        Args:
            stamp: Autopilot's time since its boot in [s].
            arrival: Our time in [s].
        """
        if not (math.isfinite(stamp) and math.isfinite(arrival)):
            return
        seen = stamp - arrival
        # However late telemetry is, its stamps go on; those of another boot begin anew.
        ahead = self.offset is not None and seen - self.offset > AHEAD
        if ahead or stamp < self._newest - BACK:
            alike = [other for other in self._doubts if abs(other - stamp) <= AHEAD]
            self._doubts = [*alike, stamp]
            if len(self._doubts) < WITNESSES:
                return
            self.restarts += 1
            self.forget()
        self._doubts, self._newest = [], max(self._newest, stamp)
        if not self._trips:
            self.offset = seen if self.offset is None else max(self.offset, seen)

    def see_answer(self, sent: float, answered: float, arrival: float) -> None:
        """Take in an answer to a round trip.

        Args:
            sent: Our time when it was asked in [s].
            answered: Autopilot's time when it answered in [s].
            arrival: Our time when the answer came in [s].
        """
        duration = arrival - sent
        if not (0.0 <= duration <= LONGEST and math.isfinite(answered)):
            return
        trip = RoundTrip(answered - 0.5 * (sent + arrival), duration)
        if self._trips and abs(trip.offset - self._trips[-1].offset) > AHEAD:
            # Of another boot, or the clock stood still: those that agree count from now on.
            alike = [other for other in self._strays if abs(other.offset - trip.offset) <= AHEAD]
            self._strays = [*alike, trip]
            if len(self._strays) < WITNESSES:
                return
            self._trips.clear()
            self._trips.extend(self._strays)
        else:
            self._trips.append(trip)
        self._strays = []
        best = min(self._trips, key=lambda each: each.duration)
        self.offset, self.delay = best.offset, 0.5 * best.duration
        mean = sum(each.offset for each in self._trips) / len(self._trips)
        spread = sum((each.offset - mean) ** 2 for each in self._trips)
        self.jitter = math.sqrt(spread / len(self._trips))

    def ours(self, stamp: float) -> float:
        """Our time of a stamp of the autopilot in [s].

        Args:
            stamp: Autopilot's time since its boot in [s].

        Raises:
            ValueError: Nothing is known of its clock.
        """
        if self.offset is None:
            raise ValueError("nothing is known of the autopilot's clock")
        return stamp - self.offset
