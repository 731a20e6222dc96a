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

"""How long solves take, and how old a state is when its command is sent."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._html import block, number, table
from uav_tracking_mpc.view.panel._recent import Recent
from uav_tracking_mpc.view.sight import Sight

SPAN = 60.0  # s
POINTS = 3000  # kept at most


class Timing(PanelPart):
    """A table: now, median and 99th percentile of the last minute."""

    name = "timing"
    order = 35.0
    period = 0.5

    def add(self) -> None:
        """Begin with an empty one."""
        self._recent = Recent(self.flight, SPAN)
        self._points: deque[tuple[float, float, float]] = deque(maxlen=POINTS)
        with self.gui.add_folder("Timing"):
            self._table = self.gui.add_html("")

    def show(self, sight: Sight) -> None:
        """Write the times of now and of the last minute.

        Args:
            sight: Of this aircraft.
        """
        news = self._recent.take(sight)
        if self._recent.anew:
            self._points.clear()
        self._points.extend((seen.time, seen.solve_time, seen.latency) for seen in news)
        while self._points and self._points[0][0] < sight.time - SPAN:
            self._points.popleft()
        points = np.array(self._points).reshape(-1, 3)
        rows = [
            _row("Solve time", sight.solve_time, points[:, 1]),
            _row("Latency", sight.latency, points[:, 2]),
        ]
        self._table.content = block(table(rows, ("in ms, last minute", "now", "median", "p99")))


def _row(name: str, now: float, past: np.ndarray) -> list[str]:
    known = past[np.isfinite(past)]
    median, p99 = np.percentile(known, [50.0, 99.0]) if len(known) else (math.nan, math.nan)
    return [name, *(number(1e3 * float(value), 2) for value in (now, median, p99))]
