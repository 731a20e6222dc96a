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

"""Simulated time: pause, speed and reset."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.view.panel._parameter_part import ParameterPart
from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.steering import SIMULATOR

SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
STANDS = 1.0  # s of wall time without a new state after which time is said to stand


class SimulatedTime(ParameterPart):
    """A row of buttons and a list of speeds."""

    name, title, node = "simulated_time", "Simulated time", SIMULATOR
    order = 50.0

    def add(self) -> None:
        """Add the folder and wait for the parameters."""
        super().add()
        self._time, self._since = math.nan, time.monotonic()

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`."""
        self._speed: Any = self.gui.add_dropdown(
            "speed", [f"{speed:g} x" for speed in SPEEDS], initial_value="1 x",
            hint="Simulated over wall time.",
        )  # fmt: skip
        self.add_buttons(
            "time",
            {
                "Pause": lambda: self.steering.pause(True),
                "Go on": lambda: self.steering.pause(False),
                "Reset": self.steering.reset,
            },
            "Reset puts the aircraft back to where it started.",
        )
        self.steer("speed", self._speed)

    def show(self, sight: Sight) -> None:
        """Say also whether time stands still.

        Args:
            sight: Of this aircraft.
        """
        super().show(sight)
        now = time.monotonic()
        if sight.time != self._time:
            self._time, self._since = sight.time, now
        stands = now - self._since > STANDS
        self.folder.label = f"{self.title}: stands still" if stands else self.title

    def follow(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.follow`."""
        word = f"{float(known['speed']):g} x"
        if word not in self._speed.options:
            self._speed.options = (*self._speed.options, word)
        self._speed.value = word

    def values(self, widget: str) -> dict[str, Any]:
        """See :meth:`ParameterPart.values`."""
        return {"speed": float(self._speed.value.split()[0])}
