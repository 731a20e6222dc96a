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

"""The plan with its stages, in the colour of what is flown."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.report.mode_colours import mode_colour
from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._extent import extent, finite
from uav_tracking_mpc.view.scene._palette import paint
from uav_tracking_mpc.view.sight import Sight

SHARE = 0.014  # size of a stage's point by the radius of the orbit
NOTHING = np.zeros((2, 3))


class Plan(SceneElement):
    """A line through the stages, and a point at each."""

    name = "plan"

    def add(self) -> None:
        """Begin with none."""
        colour = mode_colour(None)
        self._drawn = NOTHING
        self._line = self.scene.add_line_segments(
            f"{self.root}/plan/line",
            _segments(NOTHING),
            colour,
            thickness=2.0,
            thickness_units="screen",
            visible=False,
        )
        self._stages = self.scene.add_point_cloud(
            f"{self.root}/plan/stages",
            NOTHING,
            colour,
            point_shape="circle",
            precision="float32",
            point_shading="flat",
            visible=False,
        )

    def show(self, sight: Sight) -> None:
        """Draw the plan of now.

        Args:
            sight: Of this aircraft.
        """
        plan = sight.plan
        known = plan is not None and len(plan) > 1 and finite(plan)
        self._line.visible = self._stages.visible = known
        if plan is None or not known:
            return
        if plan is not self._drawn:
            self._drawn = plan
            points = plan.astype(np.float32)
            self._line.points, self._stages.points = _segments(points), points
        self._line.colors = self._stages.colors = paint(mode_colour(sight.mode))
        self._stages.point_size = SHARE * extent(self.flight, sight)


def _segments(points: NDArray[Any]) -> NDArray[Any]:
    return np.stack([points[:-1], points[1:]], axis=1)
