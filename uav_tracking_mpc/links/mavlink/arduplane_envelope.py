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

"""What ArduPlane's parameters allow: the envelope of the controller, and what speaks against it.

Names are looked up by presence, since they changed with versions (LIM_ROLL_CD and ROLL_LIMIT_DEG).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.links.mavlink.findings import climb_angle, first_of
from uav_tracking_mpc.links.mavlink.home_fence import HomeFence

NAMES = (
    "ROLL_LIMIT_DEG", "LIM_ROLL_CD", "AIRSPEED_MIN", "ARSPD_FBW_MIN", "AIRSPEED_MAX",
    "ARSPD_FBW_MAX", "AIRSPEED_CRUISE", "TRIM_ARSPD_CM", "AIRSPEED_STALL", "STALL_PREVENTION",
    "WP_LOITER_RAD", "TECS_CLMB_MAX", "TECS_SINK_MIN", "TECS_SINK_MAX", "TECS_TIME_CONST",
    "RLL2SRV_TCONST", "RLL2SRV_RMAX", "ARSPD_USE", "SCHED_LOOP_RATE", "GUIDED_TIMEOUT",
    "FS_LONG_ACTN", "FS_GCS_ENABL", "FENCE_ENABLE", "FENCE_ACTION", "FENCE_TYPE",
    "FENCE_ALT_MAX", "FENCE_ALT_MIN", "FENCE_RADIUS", "STICK_MIXING", "ALT_OFFSET",
)  # fmt: skip
BANK_KEPT = math.radians(2.0)  # of the autopilot's limit, so that it is never reached
LEAST_STALL_BANK = math.radians(25.0)  # apply_load_factor_roll_limits goes no lower
RATE_SHARE = 0.9  # of a greatest roll rate
FENCE_ALTITUDE_MAX, FENCE_CIRCLE, FENCE_ALTITUDE_MIN = 1, 2, 8  # bits of FENCE_TYPE
FENCE_MARGIN = 10.0  # m
FENCE_RTL = (1.0, 8.0)  # actions that take GUIDED away
SHARE_OF_LOOP = 0.8  # of the main loop's rate, that telemetry can have


class ArduPlaneEnvelope:
    """Limits that ArduPlane keeps, as the controller is to know them.

    Args:
        vehicle: Its parameters by name, in their own units [SI or deg].
        true_over_equivalent: True over equivalent airspeed where it flies [-].

    Attributes:
        cruise: Cruise airspeed, true, in [m/s]; None where it is not told.
    """

    def __init__(self, vehicle: Mapping[str, float], true_over_equivalent: float) -> None:
        self._vehicle, self._ratio = vehicle, true_over_equivalent
        cruise = first_of(vehicle, "AIRSPEED_CRUISE")
        if cruise is None and "TRIM_ARSPD_CM" in vehicle:
            cruise = 1e-2 * vehicle["TRIM_ARSPD_CM"]
        self.cruise = None if cruise is None else cruise * true_over_equivalent

    def values(self, airspeed: float) -> dict[str, Any]:
        """Parameters of the controller, by name, in [SI].

        Args:
            airspeed: At which it is to fly, true, in [m/s].
        """
        vehicle, values = self._vehicle, dict[str, Any]()
        bank = self.bank_max(airspeed)
        if bank is not None:
            values["bank_max"] = bank - BANK_KEPT
        least = first_of(vehicle, "AIRSPEED_MIN", "ARSPD_FBW_MIN")
        most = first_of(vehicle, "AIRSPEED_MAX", "ARSPD_FBW_MAX")
        if least is not None and most is not None:
            values["airspeed_min"], values["airspeed_max"] = least * self._ratio, most * self._ratio
        if "RLL2SRV_TCONST" in vehicle:
            # AP_RollController asks for a roll rate of error / TCONST. Nothing else is commanded.
            values["rate_lag"] = (vehicle["RLL2SRV_TCONST"],) * 3
        if vehicle.get("RLL2SRV_RMAX", 0.0) > 0.0:
            values["roll_rate_max"] = RATE_SHARE * math.radians(vehicle["RLL2SRV_RMAX"])
        if "TECS_CLMB_MAX" in vehicle and "TECS_SINK_MAX" in vehicle:
            climb, sink = vehicle["TECS_CLMB_MAX"], vehicle["TECS_SINK_MAX"]
            values["path_angle_max"] = climb_angle(climb, airspeed)
            values["path_angle_min"] = climb_angle(-sink, airspeed)
            values["hold_climb_max"], values["hold_sink_max"] = climb, sink
        if "TECS_SINK_MIN" in vehicle:
            values["hold_sink_idle"] = vehicle["TECS_SINK_MIN"]
        if "TECS_TIME_CONST" in vehicle:
            constant = vehicle["TECS_TIME_CONST"]
            values["hold_time"] = (constant, 1.0, constant)
        return values

    def bank_max(self, airspeed: float) -> float | None:
        """Greatest bank in [rad] that the autopilot flies; None where it is not told.

        With STALL_PREVENTION the load factor is limited by the airspeed over the stall speed
        (ArduPlane/Attitude.cpp, ``Plane::apply_load_factor_roll_limits``).

        Args:
            airspeed: True, in [m/s].
        """
        vehicle = self._vehicle
        limit = first_of(vehicle, "ROLL_LIMIT_DEG")
        if limit is None and "LIM_ROLL_CD" in vehicle:
            limit = 1e-2 * vehicle["LIM_ROLL_CD"]
        if limit is None:
            return None
        bank = math.radians(limit)
        stall = vehicle.get("AIRSPEED_STALL", 0.0) or first_of(
            vehicle, "AIRSPEED_MIN", "ARSPD_FBW_MIN"
        )
        if vehicle.get("STALL_PREVENTION", 1.0) and stall:
            load = max((airspeed / self._ratio / stall) ** 2, 1.0)
            bank = min(bank, max(math.acos(1.0 / load), LEAST_STALL_BANK))
        return bank

    def fence(self) -> HomeFence | None:
        """The fence, with a margin; None without one."""
        vehicle = self._vehicle
        if not vehicle.get("FENCE_ENABLE"):
            return None
        kinds = int(vehicle.get("FENCE_TYPE", 0.0))
        lowest = vehicle.get("FENCE_ALT_MIN") if kinds & FENCE_ALTITUDE_MIN else None
        highest = vehicle.get("FENCE_ALT_MAX") if kinds & FENCE_ALTITUDE_MAX else None
        radius = vehicle.get("FENCE_RADIUS") if kinds & FENCE_CIRCLE else None
        return HomeFence(
            -math.inf if lowest is None else lowest + FENCE_MARGIN,
            math.inf if highest is None else highest - FENCE_MARGIN,
            math.inf if radius is None else radius - FENCE_MARGIN,
        )

    def warnings(self, telemetry_rate: float) -> list[str]:
        """What the pilot should know.

        Args:
            telemetry_rate: Asked for, in [Hz].
        """
        vehicle, words = self._vehicle, []
        loop = vehicle.get("SCHED_LOOP_RATE")
        if loop is not None and SHARE_OF_LOOP * loop < telemetry_rate:
            words.append(
                f"SCHED_LOOP_RATE is {loop:g} Hz: telemetry comes at {SHARE_OF_LOOP * loop:g} Hz, "
                f"not at {telemetry_rate:g}"
            )
        timeout = vehicle.get("GUIDED_TIMEOUT")
        if timeout is not None and not 0.0 < timeout <= 5.0:
            words.append(
                f"GUIDED_TIMEOUT is {timeout:g} s: it decides how long the last bank is held when "
                "the companion falls silent, must be from 0 to 5 s"
            )
        if vehicle.get("FENCE_ENABLE") and vehicle.get("FENCE_ACTION", 1.0) not in FENCE_RTL:
            words.append(
                f"FENCE_ACTION is {vehicle['FENCE_ACTION']:g}: a breach does not take GUIDED away, "
                "1 (RTL) would"
            )
        if not vehicle.get("FENCE_ENABLE"):
            words.append("FENCE_ENABLE is 0: the autopilot has no fence of its own")
        if vehicle.get("STICK_MIXING", 0.0):
            words.append("STICK_MIXING is on: the pilot's sticks add to our bank in GUIDED")
        return words
