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

"""Lines of a flight: the orbit that is asked for, the one that is planned, and the plan."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import viser
import viser.transforms as rigid
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._drawing import chevrons, extent, finite, joined, paint, ring
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
        self._flown.colors = paint(mode_colour(sight.mode))


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
            cast_shadow=False,
            receive_shadow=False,
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
        self._line.colors = self._ghosts.batched_colors = paint(mode_colour(sight.mode))
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
        attitude = (
            rigid.SO3.from_z_radians(float(course[step]))
            @ rigid.SO3.from_y_radians(-math.atan2(float(steps[step, 2]), float(lengths[step])))
            @ rigid.SO3.from_x_radians(-math.atan(speed * speed * turned / GRAVITY))
        )
        places.append(plan[stage])
        turns.append(attitude.wxyz)
    return np.array(places, dtype=np.float32), np.array(turns, dtype=np.float32)


def _segments(points: NDArray[Any]) -> NDArray[Any]:
    return np.stack([points[:-1], points[1:]], axis=1)
