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

"""How the target moves, as the target publisher's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.parameters.registry import TARGET_MOTION
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.view.panel._parameter_part import ParameterPart
from uav_tracking_mpc.view.panel._slider import add_slider, set_slider
from uav_tracking_mpc.view.steering import TARGET

KNOWN = {known.name: known for known in specifications(TargetParameters)}
FAST = 15.0  # m/s, of a car in town


class Target(ParameterPart):
    """A list of motions and a slider."""

    name, title, node = "target", "Target", TARGET
    order = 25.0

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`."""
        motion, speed = str(known["motion"]), float(known["speed"])
        names = [*TARGET_MOTION.names, *([] if motion in TARGET_MOTION.names else [motion])]
        self._motion: Any = self.gui.add_dropdown(
            "motion",
            names,
            initial_value=motion,
            hint="A new motion begins where the target is. One that needs a speed needs it below.",
        )
        self._speed = add_slider(self.gui, KNOWN["speed"], speed, 0.0, FAST)
        self.steer("motion", self._motion)
        self.steer("speed", self._speed)

    def follow(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.follow`."""
        motion = str(known["motion"])
        if motion not in self._motion.options:  # a file that somebody else has named
            self._motion.options = (*self._motion.options, motion)
        self._motion.value = motion
        set_slider(self._speed, float(known["speed"]))

    def values(self, widget: str) -> dict[str, Any]:
        """See :meth:`ParameterPart.values`."""
        if widget == "motion":
            return {"motion": self._motion.value}
        return {"speed": float(self._speed.value)}
