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

"""How long it takes from telemetry in to the set-point that answers it."""

from __future__ import annotations

from collections import deque

import numpy as np

KEPT = 5000  # answers
AWAITED = 200  # measurements
SAME = 2e-3  # s by which the stamp of an answer may differ from its measurement's


class Latency:
    """Pairs answers with the arrival of what they answer."""

    def __init__(self) -> None:
        self._arrivals: deque[tuple[float, float]] = deque(maxlen=AWAITED)
        self._taken: deque[float] = deque(maxlen=KEPT)
        self._begin: float | None = None
        self._count = 0

    def arrived(self, stamp: float, arrival: float) -> None:
        """A measurement came.

        Args:
            stamp: Of the measurement in [s].
            arrival: When its last message came in [s].
        """
        self._arrivals.append((stamp, arrival))
        self._begin = arrival if self._begin is None else self._begin
        self._count += 1

    def answered(self, stamp: float, now: float) -> None:
        """A set-point was sent.

        Args:
            stamp: Of the measurement that it answers in [s].
            now: In [s].
        """
        for seen, arrival in reversed(self._arrivals):
            if abs(seen - stamp) <= SAME:
                self._taken.append(now - arrival)
                return

    def rate(self, now: float) -> float:
        """Measurements a second since the first, in [Hz].

        Args:
            now: In [s].
        """
        if self._begin is None or now <= self._begin:
            return 0.0
        return self._count / (now - self._begin)

    def quantile(self, share: float) -> float:
        """Latency that this share of the answers kept, in [s]; 0 without any.

        Args:
            share: From 0 to 1 [-].
        """
        return float(np.quantile(list(self._taken), share)) if self._taken else 0.0
