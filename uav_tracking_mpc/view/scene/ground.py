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

"""A grid with distances and north, and the limits: fence, floor, least distance, no-fly shapes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import viser

from uav_tracking_mpc.limits import Ball, Cylinder, Floor, Limit, Shape
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._drawing import (
    FAINT,
    GREY,
    LIMIT,
    Mesh,
    centre,
    extent,
    finite,
    ground_height,
    ring,
    turned,
)
from uav_tracking_mpc.view.watched_flight import Sight

CELLS = 2.75  # that the radius of the orbit is long, about
ROUND = (1.0, 2.0, 5.0, 10.0)
TWO = 2  # cells from one distance to the next
EACH_SIDE = 2  # distances on each side of the middle
DEPARTURE = 0.75  # by the spacing of distances: how far the flight goes before they follow
RAISED = 1.0  # m: how far the ground's height changes before the grid follows
FAR = 10_000.0  # m; beyond that distances are in km
ARROW = np.array([[0.0, 1.0, 0.0], [-0.35, -0.6, 0.0], [0.0, -0.3, 0.0], [0.35, -0.6, 0.0]])
ARROW_FACES = np.array([[0, 1, 2], [0, 2, 3]])


def cell_size(size: float) -> float:
    """Side of a cell: 1, 2 or 5 times a power of ten, in [m].

    Args:
        size: Radius of the orbit in [m].
    """
    wanted = size / CELLS
    power = 10.0 ** math.floor(math.log10(wanted))
    return power * min(ROUND, key=lambda factor: abs(math.log(factor * power / wanted)))


def distance(value: float, names: str) -> str:
    """A coordinate in words.

    Args:
        value: In [m].
        names: Letter of the positive and of the negative direction.
    """
    if value == 0.0:
        return "0"
    length = abs(value)
    words = f"{length / 1000.0:g} km" if length >= FAR else f"{length:g} m"
    return f"{words} {names[0] if value > 0.0 else names[1]}"


class Ground(SceneElement):
    """The aircraft that is first seen draws it, at the height of its target."""

    name = "ground"

    def add(self) -> None:
        """Nothing yet: its size is not known."""
        self._name = self.root.rpartition("/")[0] + "/ground-grid"
        self._middle = np.full(2, math.nan)
        self._cell = math.nan
        self._mine = False

    def show(self, sight: Sight) -> None:
        """Lay it under the flight.

        Args:
            sight: Of this aircraft.
        """
        if not self._mine:
            if self.scene.get_handle_by_name(self._name) is not None:
                return
            self._draw()
        middle, size = centre(sight)[:2], extent(self.flight, sight)
        if not finite(middle):
            return
        height = ground_height(sight)
        if abs(height - float(self._place.position[2])) > RAISED:
            self._place.position = (0.0, 0.0, height)
        spacing = TWO * cell_size(size)
        gone = np.abs(middle - self._middle).max()
        if spacing != TWO * self._cell or not gone < DEPARTURE * spacing:
            self._lay(np.round(middle / spacing) * spacing, spacing / TWO)

    def _draw(self) -> None:
        self._mine = True
        self.scene.configure_environment_map(None)  # its light washes out colours that tell things
        self._place = self.scene.add_frame(self._name, show_axes=False)
        self._grid = self.scene.add_grid(
            f"{self._name}/grid",
            infinite_grid=True,
            cell_color=FAINT,
            section_color=GREY,
            cell_thickness=0.7,
            section_thickness=1.2,
            shadow_opacity=0.0,
        )
        self._distances = [
            (axis, k, self.scene.add_label(f"{self._name}/{axis}_{k}", "", font_screen_scale=0.8))
            for axis in "xy"
            for k in range(-EACH_SIDE, EACH_SIDE + 1)
        ]
        self._north = self.scene.add_mesh_simple(
            f"{self._name}/north", ARROW, ARROW_FACES, color=GREY, side="double"
        )
        self._letter = self.scene.add_label(
            f"{self._name}/letter", "N", anchor="bottom-center", font_screen_scale=1.2
        )

    def _lay(self, middle: np.ndarray, cell: float) -> None:
        self._middle, self._cell = middle, cell
        self._grid.cell_size, self._grid.section_size = cell, 5.0 * cell
        self._grid.fade_distance = 60.0 * cell
        spacing = TWO * cell
        edge = middle - (EACH_SIDE + 0.5) * spacing
        for axis, k, label in self._distances:
            along = middle + k * spacing
            if axis == "x":
                label.text, label.position = distance(along[0], "EW"), (along[0], edge[1], 0.0)
            else:
                label.text, label.position = distance(along[1], "NS"), (edge[0], along[1], 0.0)
        top = middle[1] + (EACH_SIDE + 0.5) * spacing
        self._north.position, self._north.scale = (middle[0], top, 0.0), 0.5 * cell
        self._letter.position = (middle[0], top + 0.6 * cell, 0.0)


WALL = 0.7  # height of walls by the radius of the orbit
FLOOR = 1.4  # radius of the piece of floor that is drawn, by that of the orbit
FOLLOW = 0.05  # by the radius of the orbit: how far its centre goes before the floor follows


Move = Callable[[Sight], None]


def wall() -> Mesh:
    """Walls of an upright cylinder of radius and height 1."""
    points, faces = turned([(0.0, 1.0), (1.0, 1.0)], 48)
    return points[:, [1, 2, 0]], faces


class Limits(SceneElement):
    """Translucent walls with rims, a piece of floor, and a wire sphere about the target."""

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
            f"{place.name}/wall",
            *wall(),
            color=LIMIT,
            opacity=0.3 if shape.outside else 0.12,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
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

        return move

    def _add_floor(self, place: viser.FrameHandle, shape: Floor) -> Move:
        rim = self.add_lines(f"{place.name}/lines", ring(48), LIMIT, 1.5, True)
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

        return move

    def _add_ball(self, place: viser.FrameHandle, shape: Ball) -> Move:
        flat = ring()
        sphere = np.concatenate([flat, flat[..., [0, 2, 1]], flat[..., [2, 0, 1]]])
        self.add_lines(f"{place.name}/lines", sphere, LIMIT, 1.5, True).scale = shape.radius

        def move(sight: Sight) -> None:
            place.visible = sight.target is not None and finite(sight.target.position)
            if sight.target is not None and place.visible:
                place.position = sight.target.position

        return move
