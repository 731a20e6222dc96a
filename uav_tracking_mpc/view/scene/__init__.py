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

"""What a page draws of an aircraft.

==============  ====================================================================================
``airframe``    the aircraft as it banks and pitches, in the colour of what is flown; its shadow,
                and the line from it down to that; ghosts of the guidance laws beside it
``ground``      ground and sky, a grid with distances and north, one for all aircraft
``limits``      fence, floor, least distance and no-fly shapes, which glow as they are neared
``orbits``      the orbit that is asked for, the one that the plan ends on where that differs, the
                plan with ghosts of the aircraft; where aircraft and target were in the last minute
``target``      the target: where it is estimated, how surely, where it was measured, and where it
                is expected; the mouse drags it over the ground
``wind``        the wind, as streaks that drift with it and in words; velocity through the air, over
                ground, and the drift between them
==============  ====================================================================================

An element is a subclass of :class:`SceneElement`. It is found by its ``name``, or by an entry point
in the group ``uav_tracking_mpc.view.scene``. What cannot be drawn,
because it is not known or not finite, is hidden. Sizes follow the wanted orbit, so that an aircraft
is seen from where its whole orbit is. What elements share stands here: sizes and places of a
flight, colours, circles and meshes.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np
import viser
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.parameters.registry import ExtensionPoint
from uav_tracking_mpc.report.mode_colours import Colour
from uav_tracking_mpc.view.watched_flight import Sight, WatchedFlight


def own_node(root: str) -> str:
    """Name of the node under which all hangs that goes with an aircraft.

    Args:
        root: Of the aircraft, as of :class:`SceneElement`.
    """
    return f"{root}/aircraft/own"


class SceneElement(ABC):
    """Something that is drawn of one aircraft.

    Args:
        scene: Where to draw.
        root: Name of the node under which all of this aircraft hangs, with a slash before it.
        flight: What is drawn.
        colour: Of this aircraft, red, green, blue from 0 to 255.

    Attributes:
        name: By which it is found.
        at_aircraft: Name of a node that ``airframe`` moves with the aircraft without turning it:
            what hangs under it is sent once, and is not seen from the cockpit.
    """

    name: ClassVar[str]

    def __init__(
        self, scene: viser.SceneApi, root: str, flight: WatchedFlight, colour: Colour
    ) -> None:
        self.scene, self.root, self.flight, self.colour = scene, root, flight, colour
        self.at_aircraft = own_node(root)
        self.add()

    def add_lines(
        self,
        name: str,
        points: NDArray[np.float64],
        colour: Colour | NDArray[np.uint8],
        width: float,
        visible: bool = False,
    ) -> viser.LineSegmentsHandle:
        """Draw lines that are as wide from near as from afar.

        Args:
            name: Of the node, with that under which it hangs.
            points: Both ends of each, shape (n, 2, 3), in [m].
            colour: Red, green, blue from 0 to 255.
            width: On the screen in [pixels].
            visible: Whether they are seen at once.
        """
        return self.scene.add_line_segments(
            name, points, colour, thickness=width, thickness_units="screen", visible=visible
        )

    @abstractmethod
    def add(self) -> None:
        """Draw what stays, once."""

    @abstractmethod
    def show(self, sight: Sight) -> None:
        """Draw it as it is now; called twenty times a second, so that what stays is not sent again.

        Args:
            sight: Of this aircraft.
        """


SCENE_ELEMENT = ExtensionPoint("element of the scene", SceneElement)


UNKNOWN = 100.0  # m
SMALLEST, LARGEST = 1.0, 1e5  # m


def extent(flight: WatchedFlight, sight: Sight) -> float:
    """Radius of the wanted orbit, else its range, in [m].

    Args:
        flight: What is flown.
        sight: What there is to see of it.
    """
    size = UNKNOWN
    if sight.wanted is not None:
        size = abs(sight.wanted.radius)
    elif flight.tracking is not None:
        size = flight.tracking.range
    return min(max(size, SMALLEST), LARGEST) if math.isfinite(size) else UNKNOWN


def centre(sight: Sight) -> NDArray[np.float64]:
    """Centre of the wanted orbit, else the aircraft, in ``map``, shape (3,), in [m].

    Args:
        sight: What there is to see.
    """
    if sight.wanted is not None and finite(sight.wanted.centre):
        return sight.wanted.centre
    return sight.position


def ground_height(sight: Sight) -> float:
    """Height of the target in ``map``, else 0, in [m].

    Args:
        sight: What there is to see.
    """
    if sight.target is None or not finite(sight.target.position):
        return 0.0
    return float(sight.target.position[2])


def finite(*values: Any) -> bool:
    """Whether all values can be drawn.

    Args:
        values: Numbers or arrays of any shape.
    """
    return all(bool(np.isfinite(value).all()) for value in values)


GREY: Colour = (128, 128, 128)
FAINT: Colour = (150, 150, 150)
WIND: Colour = (86, 180, 233)
LIMIT: Colour = (213, 94, 0)


SEGMENTS = 96


def ring(dashes: int = 0) -> NDArray[np.float64]:
    """A circle.

    Args:
        dashes: It is broken into so many; whole by default.

    Returns:
        Shape (n, 2, 3).
    """
    angle = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    segments = np.stack([circle[:-1], circle[1:]], axis=1)
    if not dashes:
        return segments
    each = SEGMENTS // dashes
    return segments[np.arange(SEGMENTS) % each < 0.5 * each]


def chevrons(count: int) -> NDArray[np.float64]:
    """Arrow heads on the circle that point counter-clockwise.

    Args:
        count: How many.

    Returns:
        Shape (2 * count, 2, 3).
    """
    heads = []
    for angle in 2.0 * np.pi * np.arange(count) / count:
        tip = np.array([np.cos(angle), np.sin(angle), 0.0])
        for radius in (0.97, 1.03):
            behind = radius * np.array([np.cos(angle - 0.06), np.sin(angle - 0.06), 0.0])
            heads.append([behind, tip])
    return np.array(heads)


Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]  # points (n, 3), triangles (m, 3)


def turned(stations: ArrayLike, sides: int = 12, upright: bool = False) -> Mesh:
    """A body of revolution about x.

    Args:
        stations: x and radius of each, shape (k, 2), any unit.
        sides: Of its sections.
        upright: About z instead.
    """
    along, radius = np.asarray(stations, dtype=float).T
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    points = np.stack(
        [
            np.repeat(along, sides),
            np.outer(radius, np.cos(angle)).ravel(),
            np.outer(radius, np.sin(angle)).ravel(),
        ],
        axis=1,
    )
    here = np.arange(sides)
    there = np.roll(here, -1)
    rings = []
    for k in range(len(along) - 1):
        a, b, c, d = (ring + sides * row for ring, row in
                      ((here, k), (there, k), (here, k + 1), (there, k + 1)))  # fmt: skip
        rings += [np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]
    return points[:, [1, 2, 0]] if upright else points, np.concatenate(rings)


def plate(outline: ArrayLike, thickness: ArrayLike) -> Mesh:
    """A convex flat body.

    Args:
        outline: Its corners in order, shape (k, 3), any unit.
        thickness: From one side to the other, shape (3,), same unit.
    """
    corners, half = np.asarray(outline, dtype=float), 0.5 * np.asarray(thickness, dtype=float)
    count = len(corners)
    fan = np.stack([np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    here = np.arange(count)
    there = np.roll(here, -1)
    edge = np.concatenate(
        [np.stack([here, there, here + count], axis=1),
         np.stack([there, there + count, here + count], axis=1)]
    )  # fmt: skip
    return np.concatenate([corners + half, corners - half]), np.concatenate(
        [fan, fan[:, ::-1] + count, edge]
    )


def joined(*meshes: Mesh) -> Mesh:
    """Several as one.

    Args:
        meshes: Points, shape (n, 3), and triangles, shape (m, 3), of each.
    """
    begins = np.cumsum([0, *(len(points) for points, _ in meshes)])
    return np.concatenate([points for points, _ in meshes]), np.concatenate(
        [faces + begin for (_, faces), begin in zip(meshes, begins, strict=False)]
    )
