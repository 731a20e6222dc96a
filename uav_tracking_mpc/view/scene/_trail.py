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

"""Where something was in the last minute, as a line that dissolves with age.

Old parts are drawn as ever shorter dashes. Colour could not tell age on a light and on a dark page.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable

import numpy as np
import viser
from numpy.typing import NDArray

from uav_tracking_mpc.view.scene import Colour
from uav_tracking_mpc.view.scene._extent import finite

SPAN = 60.0  # s
STEP = 0.25  # s between points
PENDING = 4  # points that the head takes up before the whole line is sent again
JUMP = 5.0  # s; after a longer step of time, or back, the past is asked for again
SHORTEST = 0.15  # share of the oldest dash that is drawn
STANDING = 1e-3  # m; what moves less draws no line
NOTHING = np.zeros((1, 2, 3))

Past = Iterable[tuple[float, NDArray[np.float64]]]


def dashes(times: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Segments of a line, the older the shorter.

    Args:
        times: Of the points in [s], shape (n,), oldest first.
        points: In [m], shape (n, 3).

    Returns:
        Shape (m, 2, 3): those that have a length.
    """
    begin, end = points[:-1], points[1:]
    youth = np.clip(1.0 - (times[-1] - times[1:]) / SPAN, 0.0, 1.0)
    drawn = np.minimum(SHORTEST + 1.5 * youth, 1.0)[:, None]
    moved = np.linalg.norm(end - begin, axis=1) > STANDING
    return np.stack([end - drawn * (end - begin), end], axis=1)[moved]


class Trail:
    """A line that is sent once a second, and a head that joins it to where the thing is now.

    Args:
        scene: Where to draw.
        name: Of its node.
        colour: Of the line.
        past: Times [s] and places (shape (3,), [m]) of so many seconds back from now.
    """

    def __init__(
        self, scene: viser.SceneApi, name: str, colour: Colour, past: Callable[[float], Past]
    ) -> None:
        self._past = past
        self._times: deque[float] = deque()
        self._points: deque[NDArray[np.float64]] = deque()
        self._pending = 0
        self._line, self._head = (
            scene.add_line_segments(
                f"{name}/{part}",
                NOTHING,
                colour,
                thickness=2.5,
                thickness_units="screen",
                visible=False,
            )
            for part in ("line", "head")
        )

    def show(self, time: float, point: NDArray[np.float64] | None) -> None:
        """Draw it as it is now.

        Args:
            time: In [s].
            point: Where the thing is, shape (3,), in [m]; None where that is not known.
        """
        if point is None or not finite(time, point):
            return
        last = self._times[-1] if self._times else None
        if last is None or not -1e-9 <= time - last <= JUMP:
            self._begin(time)
        elif time - last >= STEP:
            self._append(time, point)
            self._pending += 1
        if self._pending > PENDING:
            self._send(self._line, len(self._times))
            self._pending = 0
        self._send(self._head, self._pending + 1, (time, point))

    def _begin(self, now: float) -> None:
        self._times.clear()
        self._points.clear()
        for time, point in self._past(SPAN):
            if finite(time, point) and time <= now:
                self._append(time, point)
        self._pending = 0
        self._send(self._line, len(self._times))

    def _append(self, time: float, point: NDArray[np.float64]) -> None:
        self._times.append(time)
        self._points.append(np.array(point))
        while self._times[0] < time - SPAN:
            self._times.popleft()
            self._points.popleft()

    def _send(
        self,
        line: viser.LineSegmentsHandle,
        count: int,
        now: tuple[float, NDArray[np.float64]] | None = None,
    ) -> None:
        times, points = list(self._times)[-count:], list(self._points)[-count:]
        if now is not None:
            times.append(now[0])
            points.append(now[1])
        segments = dashes(np.array(times), np.array(points)) if len(times) > 1 else NOTHING[:0]
        line.visible = len(segments) > 0
        if line.visible:
            line.points = segments.astype(np.float32)
