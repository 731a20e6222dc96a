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

"""The orbit to fly: range, altitude, airspeed and direction, as the controller's parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.view.panel._parameter_part import ParameterPart
from uav_tracking_mpc.view.panel._slider import add_slider, set_slider
from uav_tracking_mpc.view.steering import CONTROLLER

KNOWN = {known.name: known for known in specifications(TrackingParameters)}
DEEP = -1e4  # m; a least height below that is none


class Orbit(ParameterPart):
    """Three sliders and a list."""

    name, title, node = "orbit", "Orbit", CONTROLLER
    order = 20.0

    def build(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.build`: also unflyable values, for the controller to refuse."""
        range_, altitude, airspeed = (
            float(known[key]) for key in ("range", "altitude", "airspeed")
        )
        floor = float(known.get("height_min", DEEP))
        low = min(0.0, altitude) if floor <= DEEP else min(floor, altitude)
        spans = {
            "range": (range_, 0.1 * range_, 3.0 * range_),
            "altitude": (altitude, low, max(2.0 * altitude, range_)),
            "airspeed": (
                airspeed,
                float(known.get("airspeed_min", 0.5 * airspeed)),
                min(float(known.get("airspeed_max", 3.0 * airspeed)), 3.0 * airspeed),
            ),
        }
        self._sliders = {
            key: add_slider(self.gui, KNOWN[key], *span) for key, span in spans.items()
        }
        self._direction: Any = self.gui.add_dropdown(
            "direction", KNOWN["direction"].choices, initial_value=str(known["direction"])
        )
        for key, slider in self._sliders.items():
            self.steer(key, slider)
        self.steer("direction", self._direction)

    def follow(self, known: Mapping[str, Any]) -> None:
        """See :meth:`ParameterPart.follow`."""
        for key, slider in self._sliders.items():
            set_slider(slider, float(known[key]))
        self._direction.value = str(known["direction"])

    def values(self, widget: str) -> dict[str, Any]:
        """See :meth:`ParameterPart.values`."""
        if widget == "direction":
            return {widget: self._direction.value}
        return {widget: float(self._sliders[widget].value)}
