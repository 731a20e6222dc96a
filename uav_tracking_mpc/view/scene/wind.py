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

"""The wind: streaks that drift with it, and words; velocities through the air and over ground."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.view.scene import (
    GREY,
    WIND,
    SceneElement,
    centre,
    extent,
    finite,
    ground_height,
)
from uav_tracking_mpc.view.watched_flight import Sight

CALM = 0.2  # m/s; less is not drawn
CHANGE = 0.1  # m/s; less of a change is not sent
POINTS = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")


def words(wind: NDArray[np.float64]) -> str:
    """A wind in words: it is named by where it comes from.

    Args:
        wind: In ``map``, shape (3,), in [m/s].
    """
    east, north, _ = wind.tolist()
    sector = round(math.atan2(-north, -east) / (math.pi / 4.0)) % len(POINTS)
    return f"wind {math.hypot(east, north):.1f} m/s from {POINTS[sector]}"


ACROSS = 7  # streaks along each side of the field
REACH = 1.1  # half its side by the radius of the orbit
LONGEST = 0.6  # of a streak, by the distance between two
PER_SPEED = 0.04  # length of a streak in a wind of 1 m/s by that distance
HEAD = 0.12  # of a streak's arrow head by that distance
LOW = 0.4  # height of the field by that of the orbit: beneath what is flown
# South of the orbit, where the first view has neither legend nor panel, and a phone its middle.
WORDS = np.array([0.0, -1.2, 0.0])  # where they stand by the radius of the orbit


def streaks(speed: float) -> NDArray[np.float64]:
    """Arrows of lines in a square lattice of distance 1, all along x.

    Args:
        speed: Of the wind in [m/s].

    Returns:
        Shape (n, 2, 3).
    """
    length = min(PER_SPEED * speed, LONGEST)
    head = min(HEAD, 0.6 * length)
    half = 0.5 * length
    tip = [half, 0.0, 0.0]
    one = np.array(
        [
            [[-half, 0.0, 0.0], tip],
            [[half - head, 0.5 * head, 0.0], tip],
            [[half - head, -0.5 * head, 0.0], tip],
        ]
    )
    steps = np.arange(ACROSS) - 0.5 * (ACROSS - 1)
    # Every other row stands half a distance on, so that rows do not look like lines.
    east, north = np.meshgrid(steps, steps)
    east = east + 0.5 * (np.arange(ACROSS) % 2)[:, None]
    places = np.stack([east.ravel(), north.ravel(), np.zeros(east.size)], axis=1)
    return (places[:, None, None] + one[None]).reshape(-1, 2, 3)


class Wind(SceneElement):
    """A field of streaks between ground and orbit that drifts as fast as the wind."""

    name = "wind"

    def add(self) -> None:
        """Begin with none."""
        self._drawn = np.full(3, math.inf)
        self._place = self.scene.add_frame(f"{self.root}/wind", show_axes=False, visible=False)
        self._field = self.add_lines(f"{self.root}/wind/field", streaks(0.0), WIND, 2.0, True)
        self._label = self.scene.add_label(f"{self.root}/wind/label", "", anchor="bottom-center")

    def show(self, sight: Sight) -> None:
        """Let it drift, and turn it to the wind of now.

        Args:
            sight: Of this aircraft.
        """
        wind = sight.wind
        self._place.visible = (
            wind is not None
            and finite(wind, centre(sight), sight.time)
            and float(np.hypot(*wind[:2])) > CALM
        )
        if wind is None or not self._place.visible:
            return
        size, ground = extent(self.flight, sight), ground_height(sight)
        middle, speed = centre(sight), float(np.hypot(*wind[:2]))
        spacing = 2.0 * REACH * size / ACROSS
        along = np.array([*wind[:2], 0.0]) / speed
        # In the air's own time: the lattice begins anew after each distance, where it looks the
        # same.
        drifted = math.fmod(speed * sight.time, spacing) - 0.5 * spacing
        height = ground + LOW * (float(middle[2]) - ground)
        self._place.position, self._field.position = (*middle[:2], height), drifted * along
        self._field.scale, self._label.position = spacing, size * WORDS
        if float(np.abs(wind - self._drawn).max()) < CHANGE:
            return
        self._drawn = np.array(wind)
        half = 0.5 * math.atan2(wind[1], wind[0])
        self._field.wxyz = (math.cos(half), 0.0, 0.0, math.sin(half))
        self._field.points = streaks(speed).astype(np.float32)
        self._label.text = words(wind)


LENGTH = 0.35  # length of the airspeed's arrow by the radius of the orbit
LEAST_CHANGE = 0.01  # least change of an arrow, by its length, that is sent
HIDDEN = np.array([[0.0, 0.0, 0.0], [1e-3, 0.0, 0.0]])  # in airspeeds: inside of the aircraft
DRIFT_LEAST = 0.02  # by the airspeed; less is not drawn


def arrows(sight: Sight) -> NDArray[np.float64]:
    """The arrows in airspeeds, from the aircraft on.

    Args:
        sight: Of the aircraft, finite.

    Returns:
        Shape (3, 2, 3): over ground, through the air, and the drift from the tip of that to the tip
        of the first; the last two are hidden where there is none.
    """
    speed = max(sight.airspeed, 1.0)
    ground = sight.ground_velocity / speed
    air = np.array(air_velocity(sight.heading, sight.path_angle, sight.airspeed, math)) / speed
    origin = np.zeros(3)
    if float(np.linalg.norm(ground - air)) < DRIFT_LEAST:
        return np.array([[origin, ground], HIDDEN, HIDDEN])
    return np.array([[origin, ground], [origin, air], [air, ground]])


class Velocities(SceneElement):
    """Three arrows that close a triangle; one where the air stands still."""

    name = "velocities"

    def add(self) -> None:
        """Begin with none."""
        # Always as many arrows as colours: of another number a page complains.
        self._drawn = np.tile(HIDDEN, (3, 1, 1))
        self._arrows = self.scene.add_arrows(
            f"{self.at_aircraft}/velocities",
            self._drawn,
            np.array([self.colour, GREY, WIND], dtype=np.uint8),
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
        if np.abs(now - self._drawn).max() >= LEAST_CHANGE:
            self._drawn, self._arrows.points = now, now.astype(np.float32)
