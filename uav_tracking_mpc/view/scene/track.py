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

"""Where the aircraft was in the last minute."""

from __future__ import annotations

from uav_tracking_mpc.view.scene import SceneElement
from uav_tracking_mpc.view.scene._trail import Trail
from uav_tracking_mpc.view.sight import Sight


class Track(SceneElement):
    """A line in the colour of the aircraft that dissolves with age."""

    name = "track"

    def add(self) -> None:
        """Begin with none."""
        self._trail = Trail(
            self.scene,
            f"{self.root}/track",
            self.colour,
            lambda span: ((sight.time, sight.position) for sight in self.flight.past(span)),
        )

    def show(self, sight: Sight) -> None:
        """Draw it up to now.

        Args:
            sight: Of this aircraft.
        """
        self._trail.show(sight.time, sight.position)
