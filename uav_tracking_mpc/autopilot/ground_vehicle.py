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

"""A second vehicle on the wire, of a system of its own: what the aircraft is to circle."""

from __future__ import annotations

import math
from typing import Any

from uav_tracking_mpc.autopilot.message_rates import MessageRates
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of

RATES = {"HEARTBEAT": 1.0, "GLOBAL_POSITION_INT": 5.0}  # Hz
MODE_GUIDED_ARMED = 217  # base_mode


class GroundVehicle:
    """Drives as a motion of targets says, and tells where it is.

    Args:
        parameters: Of the motion.
        origin: Of ``map``.
        system: Its MAVLink system.

    Raises:
        ParameterError: There is no such motion.
    """

    def __init__(self, parameters: TargetParameters, origin: LocalFrame, system: int) -> None:
        self._motion, self._origin = motion_of(parameters), origin
        self._rates = MessageRates(RATES)
        self._voice = mavlink.MAVLink(None, system, 1)

    def frames(self, now: float) -> list[bytes]:
        """What it says now, packed.

        Args:
            now: Since the start in [s].
        """
        tellers = {"HEARTBEAT": self._heartbeat, "GLOBAL_POSITION_INT": self._position}
        return [bytes(tellers[name](now).pack(self._voice)) for name in self._rates.due(now)]

    def _heartbeat(self, now: float) -> Any:
        return mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_GROUND_ROVER,
            mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
            MODE_GUIDED_ARMED,
            15,
            mavlink.MAV_STATE_ACTIVE,
            3,
        )

    def _position(self, now: float) -> Any:
        latitude, longitude, altitude = self._origin.place(self._motion.position(now))
        east, north, up = (100.0 * self._motion.velocity(now)).tolist()
        heading = 100.0 * math.degrees(math.atan2(east, north)) % 36000.0
        return mavlink.MAVLink_global_position_int_message(
            round(now * 1e3),
            round(math.degrees(latitude) * 1e7),
            round(math.degrees(longitude) * 1e7),
            round(altitude * 1e3),
            round((altitude - self._origin.altitude) * 1e3),
            round(north),
            round(east),
            round(-up),
            round(heading) % 36000,
        )
