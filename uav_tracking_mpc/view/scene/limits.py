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

"""Fence, floor, least distance and no-fly shapes: every limit that has a place."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import viser
from numpy.typing import NDArray

from uav_tracking_mpc.limits import Ball, Cylinder, Floor, Limit, Shape
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._extent import centre, extent, finite, ground_height
from uav_tracking_mpc.view.scene._lathe import Mesh, turned
from uav_tracking_mpc.view.scene._palette import LIMIT
from uav_tracking_mpc.view.scene._rings import ring
from uav_tracking_mpc.view.sight import Sight

WALL = 0.7  # height of walls by the radius of the orbit
FLOOR = 1.4  # radius of the piece of floor that is drawn, by that of the orbit
FOLLOW = 0.05  # by the radius of the orbit: how far its centre goes before the floor follows


def wall() -> Mesh:
    """Walls of an upright cylinder of radius and height 1."""
    points, faces = turned([(0.0, 1.0), (1.0, 1.0)], 48)
    return points[:, [1, 2, 0]], faces


class Limits(SceneElement):
    """Translucent walls with rims, a piece of floor, and a wire sphere about the target."""

    name = "limits"

    def add(self) -> None:
        """Begin with none: they are known when the controller's parameters are."""
        self._of: TrackingParameters | None = None
        self._shapes: list[tuple[Limit, Shape]] = []
        self._nodes: list[viser.SceneNodeHandle] = []
        self._moves: list[Callable[[Sight], None]] = []

    def show(self, sight: Sight) -> None:
        """Draw those of now, and move those that go with target or orbit.

        Args:
            sight: Of this aircraft.
        """
        tracking = self.flight.tracking
        if tracking is not self._of:
            self._of = tracking
            limits = () if tracking is None else tracking.envelope.limits
            self._draw([(limit, shape) for limit in limits for shape in limit.shapes])
        for move in self._moves:
            move(sight)

    def _draw(self, shapes: list[tuple[Limit, Shape]]) -> None:
        if shapes == self._shapes:
            return
        for node in self._nodes:
            node.remove()
        self._shapes, self._nodes, self._moves = shapes, [], []
        for k, (limit, shape) in enumerate(shapes):
            name = f"{self.root}/limits/{limit.name}_{k}"
            place = self.scene.add_frame(name, show_axes=False, visible=False)
            self._nodes.append(place)
            if isinstance(shape, Cylinder):
                self._add_cylinder(place, shape, limit.label)
            elif isinstance(shape, Floor):
                self._add_floor(place, shape)
            else:
                self._add_ball(place, shape)

    def _add_cylinder(self, place: viser.FrameHandle, shape: Cylinder, label: str) -> None:
        walls = self.scene.add_mesh_simple(
            f"{place.name}/wall",
            *wall(),
            color=LIMIT,
            opacity=0.3 if shape.outside else 0.12,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )
        rim = self._lines(place, np.concatenate([ring(), ring() + np.array([0.0, 0.0, 1.0])]))
        words = self.scene.add_label(f"{place.name}/label", label, anchor="bottom-center")

        def move(sight: Sight) -> None:
            place.visible = True
            height = WALL * extent(self.flight, sight)
            place.position = (shape.east, shape.north, ground_height(sight))
            walls.scale = rim.scale = (shape.radius, shape.radius, height)
            words.position = (0.0, -shape.radius, height)

        self._moves.append(move)

    def _add_floor(self, place: viser.FrameHandle, shape: Floor) -> None:
        rim = self._lines(place, ring(48))
        words = self.scene.add_label(
            f"{place.name}/label", f"floor at {shape.height:g} m", anchor="top-center"
        )
        drawn = np.full(2, math.inf)

        def move(sight: Sight) -> None:
            size, middle = extent(self.flight, sight), centre(sight)[:2]
            place.visible = finite(middle)
            if place.visible and np.hypot(*(middle - drawn)) > FOLLOW * size:
                drawn[:] = middle
                place.position = (*middle, shape.height)
            rim.scale = FLOOR * size
            words.position = (0.0, -FLOOR * size, 0.0)

        self._moves.append(move)

    def _add_ball(self, place: viser.FrameHandle, shape: Ball) -> None:
        flat = ring()
        sphere = np.concatenate([flat, flat[..., [0, 2, 1]], flat[..., [2, 0, 1]]])
        self._lines(place, sphere).scale = shape.radius

        def move(sight: Sight) -> None:
            place.visible = sight.target is not None and finite(sight.target.position)
            if sight.target is not None and place.visible:
                place.position = sight.target.position

        self._moves.append(move)

    def _lines(
        self, place: viser.FrameHandle, points: NDArray[np.float64]
    ) -> viser.LineSegmentsHandle:
        return self.scene.add_line_segments(
            f"{place.name}/lines", points, LIMIT, thickness=1.5, thickness_units="screen"
        )
