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

"""Whether the controller commands the aircraft."""

from __future__ import annotations

from uav_tracking_mpc.view.panel._steering_part import SteeringPart
from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.steering import CONTROLLER


class Engagement(SteeringPart):
    """A row of two buttons."""

    name, title, node = "engagement", "Controller", CONTROLLER
    order = 45.0

    def add(self) -> None:
        """Add the buttons."""
        super().add()
        with self.folder:
            self.add_buttons(
                "commands",
                {
                    "Engage": lambda: self.steering.engage(True),
                    "Disengage": lambda: self.steering.engage(False),
                },
                "Let the controller command, or keep it silent.",
            )

    def show(self, sight: Sight) -> None:
        """Nothing changes by itself: the state of the flight tells what is flown.

        Args:
            sight: Of this aircraft.
        """
