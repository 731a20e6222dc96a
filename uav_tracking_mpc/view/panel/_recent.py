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

"""The past of a flight, piece by piece, as parts of the panel follow it."""

from __future__ import annotations

import math

from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.watched_flight import WatchedFlight

MARGIN = 1.0  # s; the flight may have gone on since


class Recent:
    """Hands out each sight of a flight once.

    Where time has gone back, or on by more than is kept, as the slider of a record does it, it
    begins anew.

    Args:
        flight: What is followed.
        span: How far back it begins in [s].

    Attributes:
        anew: Whether the last answer begins anew.
    """

    def __init__(self, flight: WatchedFlight, span: float) -> None:
        self._flight, self._span, self._last = flight, span, -math.inf
        self.anew = True

    def take(self, sight: Sight) -> list[Sight]:
        """Those that are not handed out yet, oldest first.

        Args:
            sight: Of now; it is the last one if time has gone on.
        """
        gone = sight.time - self._last
        self.anew = not 0.0 <= gone <= self._span
        if gone == 0.0:
            return []
        since = sight.time - self._span if self.anew else self._last
        past = self._flight.past(sight.time - since + MARGIN)
        self._last = sight.time
        return [*(seen for seen in past if since < seen.time < sight.time), sight]
