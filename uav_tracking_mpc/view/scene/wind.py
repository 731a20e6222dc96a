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

"""The wind with its speed in words; velocities through the air, over ground, and the drift."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._drawing import GREY, WIND, centre, extent, finite, paint
from uav_tracking_mpc.view.watched_flight import Sight

CALM = 0.2  # m/s; less is not drawn
CHANGE = 0.1  # m/s; less of a change is not sent
SHARE = 0.05  # length of the arrow in a wind of 1 m/s by the radius of the orbit
POINTS = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")


def words(wind: NDArray[np.float64]) -> str:
    """A wind in words: it is named by where it comes from.

    Args:
        wind: In ``map``, shape (3,), in [m/s].
    """
    east, north, _ = wind.tolist()
    sector = round(math.atan2(-north, -east) / (math.pi / 4.0)) % len(POINTS)
    return f"wind {math.hypot(east, north):.1f} m/s from {POINTS[sector]}"


class Wind(SceneElement):
    """An arrow over the centre of the orbit, at the height of the orbit."""

    name = "wind"

    def add(self) -> None:
        """Send the arrow, which points east."""
        self._drawn = np.full(3, math.inf)
        self._place = self.scene.add_frame(f"{self.root}/wind", show_axes=False, visible=False)
        self._arrow = self.scene.add_arrows(
            f"{self.root}/wind/arrow",
            np.array([[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]]),
            WIND,
            shaft_radius=0.02,
            head_radius=0.06,
            head_length=0.2,
        )
        self._label = self.scene.add_label(f"{self.root}/wind/label", "", anchor="bottom-center")

    def show(self, sight: Sight) -> None:
        """Turn and scale it to the wind of now.

        Args:
            sight: Of this aircraft.
        """
        wind = sight.wind
        self._place.visible = (
            wind is not None and finite(wind, centre(sight)) and float(np.hypot(*wind[:2])) > CALM
        )
        if wind is None or not self._place.visible:
            return
        self._place.position = centre(sight)
        if float(np.abs(wind - self._drawn).max()) < CHANGE:
            return
        self._drawn = np.array(wind)
        half = 0.5 * math.atan2(wind[1], wind[0])
        self._arrow.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))
        self._arrow.scale = SHARE * extent(self.flight, sight) * float(np.hypot(*wind[:2]))
        self._label.text = words(wind)


LENGTH = 0.35  # length of the airspeed's arrow by the radius of the orbit
LEAST_CHANGE = 0.01  # least change of an arrow, by its length, that is sent
DRIFT_LEAST = 0.02  # by the airspeed; less is not drawn


def arrows(sight: Sight) -> NDArray[np.float64]:
    """The arrows in airspeeds, from the aircraft on.

    Args:
        sight: Of the aircraft, finite.

    Returns:
        Shape (n, 2, 3): over ground, and where there is a drift, through the air and the drift from
        the tip of that to the tip of the first.
    """
    speed = max(sight.airspeed, 1.0)
    ground = sight.ground_velocity / speed
    air = np.array(air_velocity(sight.heading, sight.path_angle, sight.airspeed, math)) / speed
    origin = np.zeros(3)
    if float(np.linalg.norm(ground - air)) < DRIFT_LEAST:
        return np.array([[origin, ground]])
    return np.array([[origin, ground], [origin, air], [air, ground]])


class Velocities(SceneElement):
    """Three arrows that close a triangle; one where the air stands still."""

    name = "velocities"

    def add(self) -> None:
        """Begin with none."""
        self._drawn = np.zeros((1, 2, 3))
        self._colours = np.array([self.colour, GREY, WIND], dtype=np.uint8)
        self._arrows = self.scene.add_arrows(
            f"{self.at_aircraft}/velocities",
            self._drawn,
            paint(self.colour),
            shaft_radius=0.012,
            head_radius=0.035,
            head_length=0.1,
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Draw them as they are now.

        Args:
            sight: Of this aircraft.
        """
        self._arrows.visible = finite(
            sight.ground_velocity, sight.heading, sight.path_angle, sight.airspeed
        )
        if not self._arrows.visible:
            return
        self._arrows.scale = LENGTH * extent(self.flight, sight)
        now = arrows(sight)
        if now.shape == self._drawn.shape and np.abs(now - self._drawn).max() < LEAST_CHANGE:
            return
        if now.shape != self._drawn.shape:
            self._arrows.colors = self._colours[: len(now)]
        self._drawn, self._arrows.points = now, now.astype(np.float32)
