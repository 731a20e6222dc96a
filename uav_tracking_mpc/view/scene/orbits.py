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

"""Lines of a flight: orbits that are asked for and planned, the plan, and what was flown."""

from __future__ import annotations

import math
from collections import deque
from typing import Any, NamedTuple

import numpy as np
import viser
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import quaternion_from_euler
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene import SceneElement, chevrons, extent, finite, joined, ring
from uav_tracking_mpc.view.scene.airframe import SHARE, fuselage, wings
from uav_tracking_mpc.view.watched_flight import Sight

UPRIGHT, UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)  # seen from above: clockwise
SAME = 0.03  # by the radius: what centre and radius may differ by


class Orbits(SceneElement):
    """Circles of radius 1 that are moved and scaled; arrow heads tell the direction.

    The one that is planned is drawn where it is not the one that is asked for.
    """

    name = "orbits"

    def add(self) -> None:
        """Send the circles."""
        self._wanted, self._flown = (
            self.add_lines(
                f"{self.root}/orbits/{name}",
                np.concatenate([ring(dashes), chevrons(8)]),
                colour,
                width,
            )
            for name, dashes, colour, width in (
                ("wanted", 24, self.colour, 3.0),
                ("flown", 0, mode_colour(None), 2.5),
            )
        )

    def show(self, sight: Sight) -> None:
        """Move them to where they are.

        Args:
            sight: Of this aircraft.
        """
        _place(self._wanted, sight.wanted)
        _place(self._flown, None if _same(sight.wanted, sight.flown) else sight.flown)
        self._flown.colors = np.array(mode_colour(sight.mode), dtype=np.uint8)


def _same(one: FlownOrbit | None, other: FlownOrbit | None) -> bool:
    """Whether two circles can hardly be told apart."""
    if one is None or other is None:
        return False
    apart = float(np.linalg.norm(one.centre - other.centre)) + abs(one.radius - other.radius)
    return apart < SAME * abs(one.radius)


def _place(circle: viser.LineSegmentsHandle, orbit: FlownOrbit | None) -> None:
    circle.visible = orbit is not None and finite(orbit.centre, orbit.radius)
    if orbit is None or not circle.visible:
        return
    circle.position, circle.scale = orbit.centre, abs(float(orbit.radius))
    # Turned about an axis and not mirrored: of mirrored lines a browser draws nothing.
    circle.wxyz = UPSIDE_DOWN if orbit.radius < 0.0 else UPRIGHT


GHOSTS = (0.5, 1.0)  # of the plan's length: where ghosts of the aircraft fly it
GHOST_SHARE = 0.7 * SHARE  # length of a ghost by the radius of the orbit
NOTHING = np.zeros((2, 3))


class Plan(SceneElement):
    """A line along the plan, and ghosts of the aircraft on it."""

    name = "plan"

    def add(self) -> None:
        """Begin with none."""
        colour = mode_colour(None)
        self._drawn = NOTHING
        self._line = self.add_lines(f"{self.root}/plan/line", _segments(NOTHING), colour, 4.0)
        count = len(GHOSTS)
        self._ghosts = self.scene.add_batched_meshes_simple(
            f"{self.root}/plan/ghosts",
            *joined(fuselage(), wings()),
            np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)),
            np.zeros((count, 3)),
            batched_colors=colour,
            opacity=0.4,
            lod="off",
            side="double",
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Draw the plan of now.

        Args:
            sight: Of this aircraft.
        """
        plan = sight.plan
        known = plan is not None and len(plan) > 1 and finite(plan)
        self._line.visible = self._ghosts.visible = known
        if plan is None or not known:
            return
        if plan is not self._drawn:
            self._drawn = plan
            self._line.points = _segments(plan.astype(np.float32))
            places, turns = ghosts(plan, _speed(sight))
            self._ghosts.batched_positions, self._ghosts.batched_wxyzs = places, turns
        colour = np.array(mode_colour(sight.mode), dtype=np.uint8)
        self._line.colors = self._ghosts.batched_colors = colour
        size = GHOST_SHARE * extent(self.flight, sight)
        self._ghosts.batched_scales = np.full(len(GHOSTS), size, dtype=np.float32)


def _speed(sight: Sight) -> float:
    """Over ground in [m/s]; 0 where it is not known."""
    return float(np.linalg.norm(np.nan_to_num(sight.ground_velocity, posinf=0.0, neginf=0.0)))


def ghosts(
    plan: NDArray[np.float64], speed: float
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Where ghosts fly a plan, and how they are turned: along the path, banked as in still air.

    Args:
        plan: In [m], shape (n, 3), n > 1.
        speed: Over ground in [m/s].

    Returns:
        Places in [m], shape (k, 3), and quaternions w, x, y, z, shape (k, 4).
    """
    steps = np.diff(plan, axis=0)
    lengths = np.linalg.norm(steps[:, :2], axis=1)
    course = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    places, turns = [], []
    for share in GHOSTS:
        stage = round(share * (len(plan) - 1))
        step, before = max(stage - 1, 0), max(stage - 2, 0)
        turned = float(course[step] - course[before]) / max(float(lengths[step]), 1e-6)
        bank = -math.atan(speed * speed * turned / GRAVITY)
        climb = math.atan2(float(steps[step, 2]), float(lengths[step]))
        places.append(plan[stage])
        turns.append(quaternion_from_euler(bank, -climb, float(course[step])))
    return np.array(places, dtype=np.float32), np.array(turns, dtype=np.float32)


def _segments(points: NDArray[Any]) -> NDArray[Any]:
    return np.stack([points[:-1], points[1:]], axis=1)


SPAN = 60.0  # s
STEP = 0.25  # s between points
PENDING = 4  # points that the head takes up before the whole line is sent again
JUMP = 5.0  # s; after a longer step of time, or back, the past is asked for again
SHORTEST = 0.15  # share of the oldest dash that is drawn
STANDING = 1e-3  # m; what moves less draws no line
FASTEST = 340.0  # m/s, of sound; what moves faster was put elsewhere, as by a reset
NO_TRACK = np.zeros((1, 2, 3))
SLOW, FAST = 0.6, 1.4  # speed over ground by that through the air, at the ends of the scale
GAMMA = 2.2  # -, of sRGB
SCALE = np.array([(86, 60, 190), (200, 60, 120), (245, 150, 30)])  # from slow to fast


def speed_colour(sight: Sight) -> NDArray[np.uint8]:
    """How fast the air carries the aircraft over ground, as a colour, shape (3,).

    Args:
        sight: Of the aircraft; a speed that is not known counts as that in still air.
    """
    ratio = float(np.linalg.norm(sight.ground_velocity)) / max(sight.airspeed, 1.0)
    ratio = ratio if np.isfinite(ratio) else 1.0
    return linear(np.array([np.interp(ratio, (SLOW, 1.0, FAST), each) for each in SCALE.T]))


def linear(colour: ArrayLike) -> NDArray[np.uint8]:
    """A colour as a page takes those of single points: by how much light it is.

    Args:
        colour: As it is to look, shape (3,), from 0 to 255.
    """
    share: NDArray[np.float64] = np.divide(colour, 255.0)
    return np.asarray(np.round(255.0 * share**GAMMA), dtype=np.uint8)


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
    return np.stack([end - drawn * (end - begin), end], axis=1)[moved(times, points)]


def moved(times: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether a thing went on from each point to the next, shape (n - 1,).

    Args:
        times: Of the points in [s], shape (n,), oldest first.
        points: In [m], shape (n, 3).
    """
    steps = np.diff(points.reshape(-1, 3), axis=0)  # none where there is no point
    lengths = np.linalg.norm(steps, axis=1)
    return np.asarray((lengths > STANDING) & (lengths <= FASTEST * np.diff(times)))


class TrackPoint(NamedTuple):
    """Where a thing was.

    Attributes:
        time: Of the flight's clock in [s].
        place: Shape (3,), in [m].
        colour: Of the line that leads there, shape (3,).
    """

    time: float
    place: NDArray[np.float64]
    colour: NDArray[np.uint8]


class Track(SceneElement):
    """Where the aircraft was, coloured by its speed over ground.

    The line is sent once a second; a head joins it to where the thing is now.
    """

    name = "track"

    def add(self) -> None:
        """Begin with none."""
        self._points: deque[TrackPoint] = deque()
        self._pending = 0
        # A colour for each end from the start: a line of one colour does not become one of many.
        colours = np.tile(linear(self.colour), (1, 2, 1))
        self._line, self._head = (
            self.add_lines(f"{self.root}/{self.name}/{part}", NO_TRACK, colours, 3.0)
            for part in ("line", "head")
        )

    def place(self, sight: Sight) -> NDArray[np.float64] | None:
        """Where the thing is, shape (3,), in [m]; None where that is not known.

        Args:
            sight: Of this aircraft.
        """
        return sight.position

    def paint(self, sight: Sight) -> NDArray[np.uint8]:
        """Colour of the line there, shape (3,).

        Args:
            sight: Of this aircraft.
        """
        return speed_colour(sight)

    def show(self, sight: Sight) -> None:
        """Draw it up to now.

        Args:
            sight: Of this aircraft.
        """
        time, point = sight.time, self.place(sight)
        if point is None or not finite(time, point):
            return
        now, gone = TrackPoint(time, np.array(point), self.paint(sight)), math.inf
        if self._points:
            gone = time - self._points[-1].time
        if not -1e-9 <= gone <= JUMP:
            self._begin(time)
        elif gone >= STEP:
            self._points.append(now)
            self._pending += 1
        while self._points and self._points[0].time < time - SPAN:
            self._points.popleft()
        if self._pending > PENDING:
            _draw_track(self._line, [*self._points])
            self._pending = 0
        _draw_track(self._head, [*list(self._points)[-self._pending - 1 :], now])

    def _begin(self, now: float) -> None:
        self._points.clear()
        for sight in self.flight.past(SPAN):
            point = self.place(sight)
            if point is not None and finite(sight.time, point) and sight.time <= now:
                self._points.append(TrackPoint(sight.time, np.array(point), self.paint(sight)))
        self._pending = 0
        _draw_track(self._line, [*self._points])


def _draw_track(line: viser.LineSegmentsHandle, track: list[TrackPoint]) -> None:
    times, points, colours = (np.array([each[k] for each in track]) for k in range(3))
    went_on = moved(times, points)
    line.visible = bool(went_on.any())
    if line.visible:
        line.points = dashes(times, points).astype(np.float32)
        line.colors = np.repeat(colours[1:][went_on][:, None], 2, axis=1)


class TargetTrack(Track):
    """Where the target was."""

    name = "target_track"

    def place(self, sight: Sight) -> NDArray[np.float64] | None:
        """See :meth:`Track.place`.

        Args:
            sight: Of this aircraft.
        """
        return None if sight.target is None else sight.target.position

    def paint(self, sight: Sight) -> NDArray[np.uint8]:
        """See :meth:`Track.paint`.

        Args:
            sight: Of this aircraft.
        """
        return linear(self.colour)
