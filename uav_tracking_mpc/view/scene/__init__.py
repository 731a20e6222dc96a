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
                and the line from it down to that
``ground``      ground and sky, a grid with distances and north, one for all aircraft
``limits``      fence, floor, least distance and no-fly shapes, which glow as they are neared
``orbits``      the orbit that is asked for, the one that the plan ends on where that differs, the
                plan with ghosts of the aircraft
``tracks``      where aircraft and target were in the last minute
``target``      the target: where it is estimated, how surely, where it was measured, and where it
                is expected
``dragging``    lets the mouse drag the target over the ground
``rivals``      ghosts of the guidance laws that are flown beside
``wind``        the wind, as streaks that drift with it and in words; velocity through the air, over
                ground, and the drift between them
==============  ====================================================================================

An element is a subclass of :class:`SceneElement`. It is found by its ``name``, or by an entry point
in the group ``uav_tracking_mpc.view.scene``. What cannot be drawn,
because it is not known or not finite, is hidden. Sizes follow the wanted orbit, so that an aircraft
is seen from where its whole orbit is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

import numpy as np
import viser
from numpy.typing import NDArray

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
