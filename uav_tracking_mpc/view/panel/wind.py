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

"""Wind and gusts of the simulator, as its parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.view.panel._parameter_part import ParameterPart
from uav_tracking_mpc.view.panel._slider import add_slider, set_slider
from uav_tracking_mpc.view.steering import SIMULATOR

KNOWN = {known.name: known for known in specifications(SimulatorParameters)}
STRONG, SEVERE = 15.0, 25.0  # m/s of wind, and of gusts (23.2 is severe)
STILL = 0.01  # m/s; slower wind comes from nowhere


class Wind(ParameterPart):
    """Three sliders: how fast, from where, how gusty."""

    name, title, node = "wind", "Wind", SIMULATOR
    order = 60.0

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`."""
        speed, azimuth = from_where(known["wind"])
        self._speed = self.gui.add_slider(
            "wind [m/s]", 0.0, max(STRONG, speed), 0.5, speed, hint=KNOWN["wind"].description
        )
        self._from: Any = self.gui.add_slider(
            "from [deg]",
            0.0,
            360.0,
            5.0,
            azimuth,
            marks=((0.0, "N"), (90.0, "E"), (180.0, "S"), (270.0, "W"), (360.0, "N")),
            hint="Where the wind comes from: 0 is north, 90 is east.",
        )
        gusts = float(known["gust_intensity"])
        self._gusts = add_slider(self.gui, KNOWN["gust_intensity"], gusts, 0.0, SEVERE)
        self._gusts.label = "gusts [m/s]"
        self._up = float(known["wind"][2])
        self.steer("wind", self._speed)
        self.steer("wind", self._from)
        self.steer("gust_intensity", self._gusts)

    def follow(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.follow`."""
        speed, azimuth = from_where(known["wind"])
        self._up = float(known["wind"][2])
        set_slider(self._speed, speed)
        if speed > STILL:
            self._from.value = azimuth
        set_slider(self._gusts, float(known["gust_intensity"]))

    def values(self, widget: str) -> dict[str, Any]:
        """See :meth:`ParameterPart.values`."""
        if widget == "gust_intensity":
            return {widget: float(self._gusts.value)}
        azimuth = math.radians(self._from.value)
        east, north = (-self._speed.value * f(azimuth) for f in (math.sin, math.cos))
        return {"wind": (round(east, 6) + 0.0, round(north, 6) + 0.0, self._up)}


def from_where(wind: tuple[float, ...]) -> tuple[float, float]:
    """Speed of the wind in [m/s] and the azimuth that it comes from in [deg], from north over east.

    Still air comes from the north.

    Args:
        wind: Where it blows to in ``map``, east, north and up in [m/s].
    """
    east, north = float(wind[0]), float(wind[1])
    speed = math.hypot(east, north)
    azimuth = math.degrees(math.atan2(-east, -north)) if speed > STILL else 0.0
    return round(speed, 3), round(azimuth % 360.0, 1) % 360.0
