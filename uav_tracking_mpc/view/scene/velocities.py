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

"""Velocity through the air, over ground, and the drift between them, at the aircraft."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._extent import extent, finite
from uav_tracking_mpc.view.scene._palette import GREY, WIND, paint
from uav_tracking_mpc.view.sight import Sight

SHARE = 0.35  # length of the airspeed's arrow by the radius of the orbit
CHANGE = 0.01  # least change of an arrow, by its length, that is sent
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
        self._arrows.scale = SHARE * extent(self.flight, sight)
        now = arrows(sight)
        if now.shape == self._drawn.shape and np.abs(now - self._drawn).max() < CHANGE:
            return
        if now.shape != self._drawn.shape:
            self._arrows.colors = self._colours[: len(now)]
        self._drawn, self._arrows.points = now, now.astype(np.float32)
