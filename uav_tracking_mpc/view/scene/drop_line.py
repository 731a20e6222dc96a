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

"""The line from the aircraft down to its place on the ground, with its height to read."""

from __future__ import annotations

import math

import numpy as np

from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._extent import extent, finite, ground_height
from uav_tracking_mpc.view.scene._palette import GREY
from uav_tracking_mpc.view.scene._rings import ring
from uav_tracking_mpc.view.sight import Sight

SHARE = 0.03  # radius of the ring by that of the orbit
STEP = 0.002  # least change of the height, by the radius of the orbit, that is drawn


class DropLine(SceneElement):
    """Hangs under the aircraft, so that only a change of height is sent."""

    name = "drop_line"

    def add(self) -> None:
        """Send the line, 1 long."""
        line = np.array([[[0.0, 0.0, 0.0], [0.0, 0.0, -1.0]]])
        self._drawn = math.nan
        self._line = self.scene.add_line_segments(
            f"{self.at_aircraft}/drop_line",
            np.concatenate([line, ring() - [0.0, 0.0, 1.0]]),
            GREY,
            thickness=1.5,
            thickness_units="screen",
        )

    def show(self, sight: Sight) -> None:
        """Give it the length of now.

        Args:
            sight: Of this aircraft.
        """
        size, height = extent(self.flight, sight), float(sight.position[2]) - ground_height(sight)
        if not finite(height) or abs(height - self._drawn) < STEP * size:
            return
        self._drawn = height
        self._line.scale = (SHARE * size, SHARE * size, height)
