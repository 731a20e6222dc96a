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

"""The limits: fence, floor, least distance and no-fly shapes, which glow as they are neared."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from uav_tracking_mpc.limits import Ball, Cylinder, Floor, Limit, Shape
from uav_tracking_mpc.view.scene import (
    GREY,
    LIMIT,
    SceneElement,
    centre,
    extent,
    finite,
    ground_height,
    ring,
    turned,
)
from uav_tracking_mpc.view.watched_flight import Sight

WALLS = turned([(0.0, 1.0), (1.0, 1.0)], 48, upright=True)  # of a cylinder of radius and height 1
WALL = 0.7  # height of walls by the radius of the orbit
FLOOR = 1.4  # radius of the piece of floor that is drawn, by that of the orbit
GLOW = 0.25  # by the radius of the orbit: from how far a limit begins to glow
GLOWS = 8  # steps of it: what changes less is not sent
FAINT_OPACITY, GLOWING_OPACITY = 0.06, 0.5  # of walls, far off and at the limit
LEAST_GLOW = 0.6  # of what must not be flown into
FOLLOW = 0.05  # by the radius of the orbit: how far its centre goes before the floor follows


Move = Callable[[Sight], None]


def glow(away: float, size: float) -> float:
    """How much a limit glows, from 0 to 1, in steps.

    Args:
        away: How far the aircraft is from it in [m], negative beyond it.
        size: Radius of the orbit in [m].
    """
    near = 1.0 - away / (GLOW * size)
    return round(GLOWS * min(max(near, 0.0), 1.0)) / GLOWS if math.isfinite(near) else 0.0


def glowing(share: float) -> NDArray[np.uint8]:
    """Colour of a limit's lines, from grey to that of limits, shape (3,).

    Args:
        share: How much it glows, from 0 to 1.
    """
    return np.round(np.add(GREY, share * np.subtract(LIMIT, GREY))).astype(np.uint8)


class Limits(SceneElement):
    """Translucent walls and sphere with rims, and a piece of floor."""

    name = "limits"

    def add(self) -> None:
        """Begin with none: they are known when the controller's parameters are."""
        self._shapes: list[tuple[Limit, Shape]] = []
        self._nodes: list[viser.SceneNodeHandle] = []
        self._moves: list[Move] = []

    def show(self, sight: Sight) -> None:
        """Draw those of now, and move those that go with target or orbit.

        Args:
            sight: Of this aircraft.
        """
        tracking = self.flight.tracking
        limits = () if tracking is None else tracking.envelope.limits
        shapes = [(limit, shape) for limit in limits for shape in limit.shapes]
        if shapes != self._shapes:
            self._draw(shapes)
        for move in self._moves:
            move(sight)

    def _draw(self, shapes: list[tuple[Limit, Shape]]) -> None:
        for node in self._nodes:
            node.remove()
        self._shapes, self._nodes, self._moves = shapes, [], []
        for k, (limit, shape) in enumerate(shapes):
            name = f"{self.root}/limits/{limit.name}_{k}"
            place = self.scene.add_frame(name, show_axes=False, visible=False)
            self._nodes.append(place)
            if isinstance(shape, Cylinder):
                move = self._add_cylinder(place, shape, limit.label)
            elif isinstance(shape, Floor):
                move = self._add_floor(place, shape)
            else:
                move = self._add_ball(place, shape)
            self._moves.append(move)

    def _add_cylinder(self, place: viser.FrameHandle, shape: Cylinder, label: str) -> Move:
        walls = self.scene.add_mesh_simple(
            f"{place.name}/wall", *WALLS, color=LIMIT, opacity=FAINT_OPACITY, side="double"
        )
        rings = np.concatenate([ring(), ring() + np.array([0.0, 0.0, 1.0])])
        rim = self.add_lines(f"{place.name}/lines", rings, LIMIT, 1.5, True)
        words = self.scene.add_label(f"{place.name}/label", label, anchor="bottom-center")

        def move(sight: Sight) -> None:
            place.visible = True
            height = WALL * extent(self.flight, sight)
            place.position = (shape.east, shape.north, ground_height(sight))
            walls.scale = rim.scale = (shape.radius, shape.radius, height)
            words.position = (0.0, -shape.radius, height)
            east, north, _ = sight.position.tolist()
            inwards = shape.radius - math.hypot(east - shape.east, north - shape.north)
            near = glow(-inwards if shape.outside else inwards, extent(self.flight, sight))
            rim.colors = glowing(max(near, LEAST_GLOW if shape.outside else 0.0))
            walls.opacity = FAINT_OPACITY + near * (GLOWING_OPACITY - FAINT_OPACITY)

        return move

    def _add_floor(self, place: viser.FrameHandle, shape: Floor) -> Move:
        rim = self.add_lines(f"{place.name}/lines", ring(48), LIMIT, 1.5, True)
        words = self.scene.add_label(
            f"{place.name}/label", f"floor at {shape.height:g} m", anchor="top-center"
        )
        drawn = np.full(2, math.inf)

        def move(sight: Sight) -> None:
            size, middle = extent(self.flight, sight), centre(sight)[:2]
            near = glow(float(sight.position[2]) - shape.height, size)
            place.visible = finite(middle) and near > 0.0
            rim.colors = glowing(near)
            if finite(middle) and np.hypot(*(middle - drawn)) > FOLLOW * size:
                drawn[:] = middle
                place.position = (*middle, shape.height)
            rim.scale = FLOOR * size
            words.position = (0.0, -FLOOR * size, 0.0)

        return move

    def _add_ball(self, place: viser.FrameHandle, shape: Ball) -> Move:
        skin = self.scene.add_icosphere(
            f"{place.name}/skin", radius=shape.radius, color=GREY, opacity=FAINT_OPACITY
        )
        rim = self.add_lines(f"{place.name}/lines", ring(), GREY, 1.5, True)
        rim.scale = shape.radius

        def move(sight: Sight) -> None:
            place.visible = sight.target is not None and finite(sight.target.position)
            if sight.target is not None and place.visible:
                place.position = sight.target.position
                away = float(np.linalg.norm(sight.position - sight.target.position))
                near = glow(away - shape.radius, extent(self.flight, sight))
                rim.colors = glowing(near)
                red, green, blue = glowing(near).tolist()
                skin.color = (red, green, blue)
                skin.opacity = FAINT_OPACITY + near * (GLOWING_OPACITY - FAINT_OPACITY)

        return move
