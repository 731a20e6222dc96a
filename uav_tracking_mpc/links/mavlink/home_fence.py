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

"""An autopilot's fence about its home, as the controller and as an orbit see it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.links.mavlink.telemetry import Telemetry


class HomeFence(NamedTuple):
    """A cylinder; what it does not bound is infinite.

    Attributes:
        lowest: Least height above home in [m].
        highest: Greatest height above home in [m].
        radius: About home in [m].
    """

    lowest: float
    highest: float
    radius: float

    def values(self, telemetry: Telemetry) -> dict[str, Any]:
        """The fence as parameters of the controller, by name, in [m]; empty while home is unknown.

        Args:
            telemetry: Of the autopilot.
        """
        home, frame = telemetry.home, telemetry.frame
        if home is None or frame is None:
            return {}
        east, north, up = frame.position(home.latitude, home.longitude, home.altitude).tolist()
        values: dict[str, Any] = {}
        if math.isfinite(self.radius):
            values.update(fence_radius=self.radius, fence_centre=(east, north))
        if math.isfinite(self.lowest):
            values["height_min"] = up + self.lowest
        return values

    def refusal(self, orbit: FlownOrbit, telemetry: Telemetry) -> str:
        """Why an orbit is not inside, in words; empty if it is, or while home is unknown.

        Args:
            orbit: To be flown.
            telemetry: Of the autopilot.
        """
        home, frame = telemetry.home, telemetry.frame
        if home is None or frame is None:
            return ""
        centre = home.position(*frame.place(orbit.centre))
        up = float(centre[2])
        farthest = math.hypot(*centre[:2].tolist()) + abs(orbit.radius)
        if not self.lowest <= up <= self.highest:
            return (
                f"the orbit's height of {up:.0f} m above home is not inside the autopilot's fence, "
                f"{self.lowest:.0f} to {self.highest:.0f} m"
            )
        if farthest > self.radius:
            return (
                f"the orbit leaves the autopilot's fence: {farthest:.0f} m from home, "
                f"{self.radius:.0f}"
            )
        return ""
