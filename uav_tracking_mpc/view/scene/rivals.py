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

"""Ghosts of the guidance laws that are flown beside, with their range errors."""

from __future__ import annotations

import numpy as np
import viser
import viser.transforms as rigid

from uav_tracking_mpc.view.scene import Colour, SceneElement
from uav_tracking_mpc.view.scene._drawing import extent, finite, joined
from uav_tracking_mpc.view.scene.airframe import SHARE, fuselage, wings
from uav_tracking_mpc.view.watched_flight import RivalSight, Sight

APART = 0.7  # by the length of an aircraft: height of one's words over another's
RIVAL: Colour = (110, 110, 120)


def caption(rival: RivalSight) -> str:
    """What stands above a ghost.

    Args:
        rival: As it is seen.
    """
    return f"{rival.law}: {rival.range_error:+.1f} m"


class Rivals(SceneElement):
    """A translucent aircraft for each."""

    name = "rivals"

    def add(self) -> None:
        """Begin with none: they are asked for."""
        self._ghosts: dict[str, tuple[viser.MeshHandle, viser.LabelHandle]] = {}

    def show(self, sight: Sight) -> None:
        """Move those that fly, and hide the others.

        Args:
            sight: Of this aircraft.
        """
        size = SHARE * extent(self.flight, sight)
        seen = {rival.law: rival for rival in sight.rivals}
        for law, (body, label) in self._ghosts.items():
            body.visible = label.visible = law in seen
        for rank, (law, rival) in enumerate(seen.items(), 1):
            if not finite(rival.position, rival.heading, rival.path_angle, rival.bank):
                continue
            body, label = self._ghosts.get(law) or self._add(law)
            body.position, body.scale = rival.position, size
            body.wxyz = (
                rigid.SO3.from_z_radians(rival.heading)
                @ rigid.SO3.from_y_radians(-rival.path_angle)
                @ rigid.SO3.from_x_radians(rival.bank)
            ).wxyz
            # Words at heights of their own: where all fly well they fly at one place.
            label.position = np.add(rival.position, (0.0, 0.0, (0.5 + APART * rank) * size))
            label.text = caption(rival)

    def _add(self, law: str) -> tuple[viser.MeshHandle, viser.LabelHandle]:
        place = f"{self.root}/rivals/{law}"
        body = self.scene.add_mesh_simple(
            f"{place}/body",
            *joined(fuselage(), wings()),
            color=RIVAL,
            opacity=0.55,
            side="double",
            cast_shadow=False,
        )
        label = self.scene.add_label(f"{place}/label", "", anchor="bottom-center")
        self._ghosts[law] = body, label
        return body, label
