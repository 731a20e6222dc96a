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

"""Lines of a flight: orbits that are asked for and planned, the plan, and where things were."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._drawing import chevrons, extent, finite, paint, ring
from uav_tracking_mpc.view.watched_flight import Sight

UPRIGHT, UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)  # seen from above: clockwise


class Orbits(SceneElement):
    """Circles of radius 1 that are moved and scaled; arrow heads tell the direction."""

    name = "orbits"

    def add(self) -> None:
        """Send the circles."""
        self._wanted, self._flown = (
            self.add_lines(
                f"{self.root}/orbits/{name}",
                np.concatenate([ring(dashes), chevrons(4)]),
                colour,
                width,
            )
            for name, dashes, colour, width in (
                ("wanted", 24, self.colour, 2.5),
                ("flown", 0, mode_colour(None), 1.5),
            )
        )

    def show(self, sight: Sight) -> None:
        """Move them to where they are.

        Args:
            sight: Of this aircraft.
        """
        _place(self._wanted, sight.wanted)
        _place(self._flown, sight.flown)
        self._flown.colors = paint(mode_colour(sight.mode))


def _place(circle: viser.LineSegmentsHandle, orbit: FlownOrbit | None) -> None:
    circle.visible = orbit is not None and finite(orbit.centre, orbit.radius)
    if orbit is None or not circle.visible:
        return
    circle.position, circle.scale = orbit.centre, abs(float(orbit.radius))
    # Turned about an axis and not mirrored: of mirrored lines a browser draws nothing.
    circle.wxyz = UPSIDE_DOWN if orbit.radius < 0.0 else UPRIGHT


SHARE = 0.014  # size of a stage's point by the radius of the orbit
NOTHING = np.zeros((2, 3))


class Plan(SceneElement):
    """A line through the stages, and a point at each."""

    name = "plan"

    def add(self) -> None:
        """Begin with none."""
        colour = mode_colour(None)
        self._drawn = NOTHING
        self._line = self.add_lines(f"{self.root}/plan/line", _segments(NOTHING), colour, 2.0)
        self._stages = self.scene.add_point_cloud(
            f"{self.root}/plan/stages",
            NOTHING,
            colour,
            point_shape="circle",
            precision="float32",
            point_shading="flat",
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Draw the plan of now.

        Args:
            sight: Of this aircraft.
        """
        plan = sight.plan
        known = plan is not None and len(plan) > 1 and finite(plan)
        self._line.visible = self._stages.visible = known
        if plan is None or not known:
            return
        if plan is not self._drawn:
            self._drawn = plan
            points = plan.astype(np.float32)
            self._line.points, self._stages.points = _segments(points), points
        self._line.colors = self._stages.colors = paint(mode_colour(sight.mode))
        self._stages.point_size = SHARE * extent(self.flight, sight)


def _segments(points: NDArray[Any]) -> NDArray[Any]:
    return np.stack([points[:-1], points[1:]], axis=1)


SPAN = 60.0  # s
STEP = 0.25  # s between points
PENDING = 4  # points that the head takes up before the whole line is sent again
JUMP = 5.0  # s; after a longer step of time, or back, the past is asked for again
SHORTEST = 0.15  # share of the oldest dash that is drawn
STANDING = 1e-3  # m; what moves less draws no line
NO_TRACK = np.zeros((1, 2, 3))


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


class Track(SceneElement):
    """Where the aircraft was: a line that dissolves with age.

    The line is sent once a second; a head joins it to where the thing is now.
    """

    name = "track"

    def add(self) -> None:
        """Begin with none."""
        self._times: deque[float] = deque()
        self._points: deque[NDArray[np.float64]] = deque()
        self._pending = 0
        self._line, self._head = (
            self.add_lines(f"{self.root}/{self.name}/{part}", NO_TRACK, self.colour, 2.5)
            for part in ("line", "head")
        )

    def place(self, sight: Sight) -> NDArray[np.float64] | None:
        """Where the thing is, shape (3,), in [m]; None where that is not known.

        Args:
            sight: Of this aircraft.
        """
        return sight.position

    def show(self, sight: Sight) -> None:
        """Draw it up to now.

        Args:
            sight: Of this aircraft.
        """
        time, point = sight.time, self.place(sight)
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
        for sight in self.flight.past(SPAN):
            point = self.place(sight)
            if point is not None and finite(sight.time, point) and sight.time <= now:
                self._append(sight.time, point)
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
        segments = dashes(np.array(times), np.array(points)) if len(times) > 1 else NO_TRACK[:0]
        line.visible = len(segments) > 0
        if line.visible:
            line.points = segments.astype(np.float32)


class TargetTrack(Track):
    """Where the target was."""

    name = "target_track"

    def place(self, sight: Sight) -> NDArray[np.float64] | None:
        """See :meth:`Track.place`.

        Args:
            sight: Of this aircraft.
        """
        return None if sight.target is None else sight.target.position
