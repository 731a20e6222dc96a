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

"""What PX4's parameters allow: the envelope of the controller, and what speaks against it.

In OFFBOARD with attitudes PX4 keeps none of its limits of bank, pitch, thrust and airspeed itself,
for the modules that know them do not run (src/modules/commander/ModeUtil/control_mode.cpp,
``getVehicleControlMode``; src/modules/fw_mode_manager, fw_lateral_longitudinal_control): the link
does, by what is read here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.links.mavlink.energy_law import EnergyLimits
from uav_tracking_mpc.links.mavlink.findings import climb_angle
from uav_tracking_mpc.links.mavlink.home_fence import HomeFence
from uav_tracking_mpc.links.mavlink.listener import FIXED_WING

DEFAULTS = {
    "FW_THR_MIN": 0.0, "FW_THR_MAX": 1.0, "FW_THR_TRIM": 0.6, "FW_THR_ASPD_MIN": 0.0,
    "FW_THR_ASPD_MAX": 0.0, "FW_THR_SLEW_MAX": 0.0, "FW_T_CLMB_MAX": 5.0, "FW_T_SINK_MIN": 2.0,
    "FW_T_SINK_MAX": 5.0, "FW_T_VERT_ACC": 7.0, "FW_T_RLL2THR": 15.0, "FW_P_LIM_MIN": -30.0,
    "FW_P_LIM_MAX": 30.0, "FW_P_TC": 0.4, "FW_P_RMAX_POS": 60.0, "FW_P_RMAX_NEG": 60.0,
    "FW_R_RMAX": 70.0, "FW_PN_R_SLEW_MAX": 90.0,
}  # fmt: skip
NEEDED = ("FW_R_LIM", "FW_AIRSPD_MIN", "FW_AIRSPD_TRIM", "FW_AIRSPD_MAX")
NAMES = (
    *NEEDED, *DEFAULTS, "FW_R_TC", "COM_OF_LOSS_T", "COM_OBL_RC_ACT", "COM_RCL_EXCEPT",
    "NAV_RCL_ACT", "NAV_DLL_ACT", "COM_DL_LOSS_T", "GF_ACTION", "GF_MAX_HOR_DIST",
    "GF_MAX_VER_DIST", "MAV_TYPE", "MAV_FWDEXTSP", "NAV_LOITER_RAD", "FW_USE_AIRSPD",
    "MAV_SIGN_CFG",
)  # fmt: skip
BANK_KEPT = math.radians(2.0)  # of the limit, so that it is never reached
LEAST_TURN_BANK = math.radians(25.0)  # at any airspeed: load factor 1.1
RATE_SHARE = 0.9  # of a greatest rate
FORCE_SHARE = 0.25  # of the engine's excess, that is left at the greatest airspeed at least
FREE_THRUST_SLEW = 2.0  # 1/s, where PX4 limits none
FENCE_MARGIN = 10.0  # m
LOSS_ACTIONS = {
    0: "Position", 1: "Altitude", 2: "Stabilized", 3: "Return", 4: "Land", 5: "Hold",
    6: "Terminate", 7: "Disarm",
}  # of COM_OBL_RC_ACT: failsafe.cpp, fromOffboardLossActParam  # fmt: skip
ENDS_WELL = (3.0, 5.0)
LONGEST_LOSS, SHORTEST_LOSS = 5.0, 0.3  # s, of COM_OF_LOSS_T
OFFBOARD_BIT = 4  # of COM_RCL_EXCEPT
FATAL = {5: "terminates the flight", 6: "disarms"}  # of NAV_RCL_ACT and NAV_DLL_ACT
FENCE_TERMINATES = 4.0  # of GF_ACTION


class Px4Envelope:
    """Limits that the link keeps for PX4, as the controller is to know them.

    Args:
        vehicle: PX4's parameters by name, in their own units [SI or deg]; those that this version
            does not have count as their defaults, where that harms nobody.
        true_over_equivalent: True over equivalent airspeed where it flies [-].

    Attributes:
        cruise: Trim airspeed, true, in [m/s]; None where it is not told.
    """

    def __init__(self, vehicle: Mapping[str, float], true_over_equivalent: float) -> None:
        self._given, self._ratio = vehicle, true_over_equivalent
        self._vehicle = {**DEFAULTS, **vehicle}
        trim = vehicle.get("FW_AIRSPD_TRIM")
        self.cruise = None if trim is None else trim * true_over_equivalent

    def values(self, airspeed: float) -> dict[str, Any]:
        """Parameters of the controller, by name, in [SI].

        Args:
            airspeed: At which it is to fly, true, in [m/s].
        """
        vehicle, values = self._vehicle, dict[str, Any]()
        if (bank := self.bank_max(airspeed)) is not None:
            values["bank_max"] = bank - BANK_KEPT
        values["roll_rate_max"] = RATE_SHARE * self.roll_slew
        values["pitch_rate_max"] = vehicle["FW_T_VERT_ACC"] / airspeed
        climb, sink = vehicle["FW_T_CLMB_MAX"], vehicle["FW_T_SINK_MAX"]
        values["path_angle_max"] = climb_angle(climb, airspeed)
        values["path_angle_min"] = climb_angle(-sink, airspeed)
        if {"FW_AIRSPD_MIN", "FW_AIRSPD_MAX"} <= self._given.keys():
            least = vehicle["FW_AIRSPD_MIN"] * self._ratio
            most = vehicle["FW_AIRSPD_MAX"] * self._ratio
            values["airspeed_min"], values["airspeed_max"] = least, most
            values.update(self._forces(most))
        return values

    def _forces(self, most: float) -> dict[str, Any]:
        """Thrust less drag at the ends of the airspeed, the drag growing with its square."""
        if self.cruise is None:
            return {}
        climb, idle = self._vehicle["FW_T_CLMB_MAX"], self._vehicle["FW_T_SINK_MIN"]
        per_climb = GRAVITY / self.cruise
        fast = max(climb - idle * ((most / self.cruise) ** 2 - 1.0), FORCE_SHARE * climb)
        return {
            "force_max": (per_climb * climb, per_climb * fast),
            "force_min": (-per_climb * idle, -per_climb * idle),
        }

    def bank_max(self, airspeed: float) -> float | None:
        """Greatest bank in [rad] that is ever commanded; None where FW_R_LIM is not told.

        The least airspeed of a turn grows with the root of its load factor
        (src/lib/fw_performance_model, ``PerformanceModel::getMinimumCalibratedAirspeed``).

        Args:
            airspeed: True, in [m/s].
        """
        limit = self._given.get("FW_R_LIM")
        if limit is None:
            return None
        bank = math.radians(limit)
        if least := self._given.get("FW_AIRSPD_MIN", 0.0):
            load = max((airspeed / self._ratio / least) ** 2, 1.0)
            bank = min(bank, max(math.acos(1.0 / load), LEAST_TURN_BANK))
        return bank

    @property
    def roll_slew(self) -> float:
        """How quickly the commanded bank changes at most in [rad/s]."""
        slew = min(self._vehicle["FW_R_RMAX"], self._vehicle["FW_PN_R_SLEW_MAX"])
        return math.radians(slew)

    def energy_limits(self) -> EnergyLimits:
        """What the energy law is to know and to keep."""
        vehicle = self._vehicle
        cruise = vehicle.get("FW_AIRSPD_TRIM", 15.0)
        slew = vehicle["FW_THR_SLEW_MAX"]
        return EnergyLimits(
            cruise=cruise,
            airspeed_min=vehicle.get("FW_AIRSPD_MIN", cruise),
            airspeed_max=vehicle.get("FW_AIRSPD_MAX", cruise),
            thrust_min=max(vehicle["FW_THR_MIN"], 0.0),
            thrust_max=min(vehicle["FW_THR_MAX"], 1.0),
            trim=vehicle["FW_THR_TRIM"],
            trim_slow=vehicle["FW_THR_ASPD_MIN"],
            trim_fast=vehicle["FW_THR_ASPD_MAX"],
            climb_max=vehicle["FW_T_CLMB_MAX"],
            sink_idle=vehicle["FW_T_SINK_MIN"],
            load_energy=vehicle["FW_T_RLL2THR"],
            pitch_min=math.radians(vehicle["FW_P_LIM_MIN"]),
            pitch_max=math.radians(vehicle["FW_P_LIM_MAX"]),
            pitch_time=vehicle["FW_P_TC"],
            pitch_slew=math.radians(min(vehicle["FW_P_RMAX_POS"], vehicle["FW_P_RMAX_NEG"])),
            thrust_slew=slew if slew > 0.0 else FREE_THRUST_SLEW,
        )

    def fence(self) -> HomeFence | None:
        """The fence, with a margin; None without one."""
        vehicle = self._given
        highest = vehicle.get("GF_MAX_VER_DIST", 0.0)
        radius = vehicle.get("GF_MAX_HOR_DIST", 0.0)
        if not vehicle.get("GF_ACTION") or (highest <= 0.0 and radius <= 0.0):
            return None
        return HomeFence(
            -math.inf,
            highest - FENCE_MARGIN if highest > 0.0 else math.inf,
            radius - FENCE_MARGIN if radius > 0.0 else math.inf,
        )

    def refusals(self) -> list[str]:
        """Why it is not flown by this link, in words."""
        vehicle = self._given
        words = [f"{name} cannot be read" for name in NEEDED if name not in vehicle]
        if vehicle.get("MAV_TYPE", 1.0) not in FIXED_WING:
            words.append(
                f"MAV_TYPE is {vehicle['MAV_TYPE']:g}: its thrust would be another vehicle's, must "
                "be 1 (fixed wing)"
            )
        if vehicle.get("MAV_FWDEXTSP", 1.0) != 1.0:
            words.append("MAV_FWDEXTSP is 0: it drops a companion's set-points, must be 1")
        action = vehicle.get("COM_OBL_RC_ACT")
        if action is not None and action not in ENDS_WELL:
            name = LOSS_ACTIONS.get(int(action), "unknown")
            words.append(
                f"COM_OBL_RC_ACT is {action:g} ({name}): where the companion falls silent it must "
                "end in 5 (Hold) or 3 (Return)"
            )
        loss = vehicle.get("COM_OF_LOSS_T")
        if loss is not None and not SHORTEST_LOSS <= loss <= LONGEST_LOSS:
            words.append(
                f"COM_OF_LOSS_T is {loss:g} s: the last attitude and thrust are held that long "
                f"when the companion falls silent, must be from {SHORTEST_LOSS:g} to "
                f"{LONGEST_LOSS:g} s"
            )
        low, trim, high = (self._vehicle[f"FW_THR_{end}"] for end in ("MIN", "TRIM", "MAX"))
        if not 0.0 <= low < trim < high <= 1.0:
            words.append(
                f"FW_THR_TRIM is {trim:g}, must be between FW_THR_MIN = {low:g} and FW_THR_MAX = "
                f"{high:g}, from 0 to 1"
            )
        if not words:
            slow, cruise, fast = (vehicle[name] for name in NEEDED[1:])
            if not 0.0 < slow < cruise < fast:
                words.append(
                    f"FW_AIRSPD_TRIM is {cruise:g} m/s, must be between FW_AIRSPD_MIN = {slow:g} "
                    f"and FW_AIRSPD_MAX = {fast:g} m/s"
                )
        return words

    def warnings(self) -> list[str]:
        """What the pilot should know."""
        vehicle, words = self._given, []
        for name in ("COM_OBL_RC_ACT", "COM_OF_LOSS_T"):
            if name not in vehicle:
                words.append(f"{name} cannot be read: see what PX4 does when the companion dies")
        if int(vehicle.get("COM_RCL_EXCEPT", 0.0)) & OFFBOARD_BIT:
            words.append(
                f"COM_RCL_EXCEPT is {vehicle['COM_RCL_EXCEPT']:g}: OFFBOARD goes on without the "
                "pilot's transmitter, who then cannot take over; without bit 2 it would not"
            )
        for name, lost in {"NAV_RCL_ACT": "transmitter", "NAV_DLL_ACT": "ground station"}.items():
            action = int(vehicle.get(name, 0.0))
            if fatal := FATAL.get(action):
                words.append(
                    f"{name} is {action}: the loss of the {lost} {fatal}, 2 (Return) would not"
                )
        if vehicle.get("NAV_DLL_ACT"):
            words.append(
                f"NAV_DLL_ACT is {vehicle['NAV_DLL_ACT']:g}: OFFBOARD ends "
                f"{vehicle.get('COM_DL_LOSS_T', 10.0):g} s after the last heartbeat of a ground "
                "station, which a companion's does not replace"
            )
        if self.fence() is None:
            words.append(
                "GF_ACTION, GF_MAX_HOR_DIST and GF_MAX_VER_DIST set no fence of the autopilot's own"
            )
        elif vehicle.get("GF_ACTION") == FENCE_TERMINATES:
            words.append("GF_ACTION is 4: a breach of the fence terminates the flight")
        if vehicle.get("FW_USE_AIRSPD", 1.0) == 0.0:
            words.append(
                "FW_USE_AIRSPD is 0: the attitude loops take every airspeed for FW_AIRSPD_TRIM"
            )
        if vehicle.get("MAV_SIGN_CFG", 0.0):
            words.append("MAV_SIGN_CFG is on: only messages signed with its key are heard")
        return words
