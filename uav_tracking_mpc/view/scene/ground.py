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

"""Ground and sky: a tinted grid with distances and north, and a dome that meets it."""

from __future__ import annotations

import math

import numpy as np
import trimesh
from PIL import Image

from uav_tracking_mpc.view.scene import (
    FAINT,
    GREY,
    SceneElement,
    centre,
    extent,
    finite,
    ground_height,
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


AMBIENT = 2.0  # without it what is turned away from the light is black
# Translucent, so that light and dark pages keep their own brightness.
GROUND, GROUND_OPACITY = (96, 125, 88), 0.22
SKY = np.array([(150, 175, 195), (90, 145, 205), (40, 90, 170)])  # horizon, 20 deg up, zenith
SKY_OPACITY = 0.45
MIST = 8.0  # deg over the horizon in which the sky comes out of what is behind it
SKY_RADIUS = 30_000.0  # m; within what a camera sees
# m, how deep the origin of the sky lies: what is translucent is drawn from the farthest origin on.
BEHIND_ALL = 1e6


def sky() -> trimesh.Trimesh:
    """A dome that shines by itself, its origin far below it."""
    elevation = np.radians([0.0, 2.0, 4.0, 6.0, 10.0, 20.0, 40.0, 65.0, 90.0])
    stations = np.stack([np.sin(elevation), np.cos(elevation)], axis=1)
    points, faces = turned(stations, 48, upright=True)
    points = SKY_RADIUS * points + [0.0, 0.0, BEHIND_ALL]
    up = np.repeat(np.degrees(elevation), 48)
    heights = np.linspace(90.0, 0.0, 64)  # of the rows of the picture, from its top
    rows = [np.interp(heights, (0.0, 20.0, 90.0), channel) for channel in SKY.T]
    opacity = 255.0 * SKY_OPACITY * np.clip(heights / MIST, 0.0, 1.0)
    light = np.stack([*rows, opacity], axis=1).round().astype(np.uint8)[:, None]
    light = np.repeat(light, 2, axis=1)
    dark = light * np.array([0, 0, 0, 1], dtype=np.uint8)
    material = trimesh.visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(dark),
        emissiveTexture=Image.fromarray(light[..., :3].copy()),
        emissiveFactor=[1.0, 1.0, 1.0],
        metallicFactor=0.0,
        roughnessFactor=1.0,
        alphaMode="BLEND",
        doubleSided=True,
    )
    across = np.full(len(up), 0.5)
    visual = trimesh.visual.TextureVisuals(
        uv=np.stack([across, 0.01 + 0.98 * up / 90.0], axis=1), material=material
    )
    return trimesh.Trimesh(points, faces, visual=visual, process=False)


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
        # The shadow of the aircraft is an element. Without a graphics card, shadows that are
        # computed from the lights take half of a frame.
        self.scene.configure_default_lights(cast_shadow=False)
        self._place = self.scene.add_frame(self._name, show_axes=False)
        self._grid = self.scene.add_grid(
            f"{self._name}/grid",
            infinite_grid=True,
            cell_color=FAINT,
            section_color=GREY,
            cell_thickness=0.7,
            section_thickness=1.2,
            shadow_opacity=0.0,
            plane_color=GROUND,
            plane_opacity=GROUND_OPACITY,
        )
        self.scene.add_light_ambient(f"{self._name}/light", intensity=AMBIENT)
        self._sky = self.scene.add_mesh_trimesh(f"{self._name}/sky", sky())
        self._distances = [
            (
                axis,
                k,
                self.scene.add_label(  # behind what flies before it
                    f"{self._name}/{axis}_{k}", "", font_screen_scale=0.8, depth_test=True
                ),
            )
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
        self._sky.position = (*middle, -BEHIND_ALL)
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
