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

"""Range error, bank and cost over the last minutes."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.view.panel import PanelPart
from uav_tracking_mpc.view.panel._recent import Recent
from uav_tracking_mpc.view.sight import Sight

SPAN = 180.0  # s
RESOLUTION = 0.5  # s between points
POINTS = int(SPAN / RESOLUTION)
HEIGHT = 120  # pixels
BLUE, ORANGE, FALLBACK = "rgb(0,130,200)", "rgb(213,94,0)", "rgba(230,159,0,0.3)"
COST = "Cost"
LEAST_COST = 1e-6  # [-]; the axis of the cost is logarithmic


class Plots(PanelPart):
    """Three plots over the time before now; what is shaded was flown by a fallback mode."""

    name = "plots"
    order = 30.0
    period = 0.5

    def add(self) -> None:
        """Add them; each appears with its first point."""
        self._recent = Recent(self.flight, SPAN)
        self._points: deque[tuple[float, ...]] = deque(maxlen=POINTS)
        with self.gui.add_folder(f"Last {SPAN:.0f} s"):
            self._range = self._plot("Range error [m]", [("range error", BLUE)])
            self._bank = self._plot(
                "Bank, right wing down [deg]",
                [("bank", BLUE), ("limit", ORANGE), ("limit", ORANGE)],
            )
            self._cost = self._plot(COST, [("cost", BLUE)], distr=3)

    def _plot(self, title: str, lines: list[tuple[str, str]], **scale: Any) -> Any:
        series: list[Any] = [{"label": "s"}]
        series += [{"label": "fallback", "scale": "mode", "fill": FALLBACK, "width": 0}]
        series += [
            {"label": label, "stroke": colour, "width": 1.5, "points": {"show": False}}
            for label, colour in lines
        ]
        scales: Any = {
            "x": {"time": False, "range": (-SPAN, 0.0)},
            "y": scale,
            "mode": {"range": (0.0, 1.0)},
        }
        return self.gui.add_uplot(
            tuple(np.zeros(1) for _ in series),
            tuple(series),
            title=title,
            scales=scales,
            legend={"show": False},
            axes=(
                {"size": 30, "ticks": {"show": False}},
                {"size": 55, "ticks": {"show": False}, "grid": {"show": title != COST}},
            ),
            height=HEIGHT,
            padding=(8, 12, 0, 0),
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Draw what was seen.

        Args:
            sight: Of this aircraft.
        """
        news = self._recent.take(sight)
        if self._recent.anew:
            self._points.clear()
        for seen in news:
            if not self._points or seen.time - self._points[-1][0] >= 0.99 * RESOLUTION:
                fallback = float(seen.mode is not None and not seen.mode.nominal)
                error = seen.errors.get("range_error", math.nan)
                bank = math.degrees(seen.bank)
                self._points.append((seen.time, fallback, error, bank, seen.cost))
        while self._points and self._points[0][0] < sight.time - SPAN:
            self._points.popleft()
        if not self._points:
            return
        time, fallback, error, bank, cost = np.array(self._points).T
        time = time - sight.time
        tracking = self.flight.tracking
        limit = math.nan if tracking is None else math.degrees(tracking.bank_max)
        limits = np.full_like(bank, limit), np.full_like(bank, -limit)
        _draw(self._range, time, fallback, error)
        _draw(self._bank, time, fallback, bank, *limits)
        _draw(self._cost, time, fallback, np.maximum(cost, LEAST_COST))


def _draw(
    plot: Any, time: NDArray[np.float64], fallback: NDArray[np.float64], *lines: NDArray[np.float64]
) -> None:
    """Points at which the first line is known; a plot without any does not appear."""
    known = np.isfinite(lines[0])
    plot.visible = bool(known.any())
    if plot.visible:
        plot.data = tuple(line[known] for line in (time, fallback, *lines))
