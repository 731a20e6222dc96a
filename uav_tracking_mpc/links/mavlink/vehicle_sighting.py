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

"""A vehicle to circle that tells where it is: GLOBAL_POSITION_INT or FOLLOW_TARGET."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.links import Sighting
from uav_tracking_mpc.links.mavlink.autopilot_clock import AutopilotClock
from uav_tracking_mpc.links.mavlink.telemetry import DEGREE_SCALE

HAS_VELOCITY = 0b10  # of FOLLOW_TARGET's est_capabilities


class VehicleSighting:
    """Follows one MAVLink system.

    Its clock is not ours; the least delay of its messages aligns the two.
    """

    def __init__(self) -> None:
        self._clock = AutopilotClock()
        self._newest: Sighting | None = None

    def take(self) -> Sighting | None:
        """The newest sighting that nobody has taken yet."""
        newest, self._newest = self._newest, None
        return newest

    def see(self, message: Any, arrival: float, frame: LocalFrame) -> None:
        """Take in a message.

        Args:
            message: Of that system.
            arrival: Our time in [s].
            frame: Axes of ``map``.
        """
        kind = message.get_type()
        if kind == "GLOBAL_POSITION_INT":
            time, altitude = message.time_boot_ms * 1e-3, message.alt * 1e-3
            velocity = [message.vy * 1e-2, message.vx * 1e-2, -message.vz * 1e-2]
        elif kind == "FOLLOW_TARGET":
            time, altitude = message.timestamp * 1e-3, message.alt
            north, east, down = message.vel
            velocity = [east, north, -down] if message.est_capabilities & HAS_VELOCITY else []
        else:
            return
        if not math.isfinite(altitude + sum(velocity)) or message.lat == message.lon == 0:
            return
        self._clock.see_stamp(time, arrival)
        if self._clock.offset is None:
            return
        position = frame.position(message.lat * DEGREE_SCALE, message.lon * DEGREE_SCALE, altitude)
        stamp = min(self._clock.ours(time), arrival)
        self._newest = Sighting(stamp, position, np.array(velocity) if velocity else None)
