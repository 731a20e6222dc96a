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

"""The orbit that is asked for, and the one that the plan ends on."""

from __future__ import annotations

import numpy as np
import viser

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene import Colour, SceneElement
from uav_tracking_mpc.view.scene._extent import finite
from uav_tracking_mpc.view.scene._palette import paint
from uav_tracking_mpc.view.scene._rings import chevrons, ring
from uav_tracking_mpc.view.sight import Sight

UPRIGHT, UPSIDE_DOWN = (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0)  # seen from above: clockwise


class Orbits(SceneElement):
    """Circles of radius 1 that are moved and scaled; arrow heads tell the direction."""

    name = "orbits"

    def add(self) -> None:
        """Send the circles."""
        self._wanted = self._circle("wanted", 24, self.colour, 2.5)
        self._flown = self._circle("flown", 0, mode_colour(None), 1.5)

    def _circle(
        self, name: str, dashes: int, colour: Colour, width: float
    ) -> viser.LineSegmentsHandle:
        return self.scene.add_line_segments(
            f"{self.root}/orbits/{name}",
            np.concatenate([ring(dashes), chevrons(4)]),
            colour,
            thickness=width,
            thickness_units="screen",
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Move them to where they are.

        Args:
            sight: Of this aircraft.
        """
        _place(self._wanted, sight.wanted)
        _place(self._flown, sight.flown)
        self._flown.colors = paint(mode_colour(sight.mode))


def _place(circle: viser.LineSegmentsHandle, orbit: FlownOrbit | None) -> None:
    circle.visible = orbit is not None and finite(orbit.centre, orbit.radius)
    if orbit is None or not circle.visible:
        return
    circle.position, circle.scale = orbit.centre, abs(float(orbit.radius))
    # Turned about an axis and not mirrored: of mirrored lines a browser draws nothing.
    circle.wxyz = UPSIDE_DOWN if orbit.radius < 0.0 else UPRIGHT
