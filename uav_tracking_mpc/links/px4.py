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

"""PX4 in OFFBOARD: it is told attitude and thrust, all three inputs are ours.

=========================  ==================================================================
SET_ATTITUDE_TARGET        bank, from the turn rate; pitch and thrust, from the energy law
DO_SET_MODE                enters OFFBOARD; Hold, when command is given back
CURRENT_MODE, HEARTBEAT    who flies; the former ten times a second where PX4 has it
=========================  ==================================================================

Read in PX4's sources: the set-point counts only with MAV_FWDEXTSP, as proof of life even outside of
OFFBOARD, and carries no thrust where it says that thrust is to be ignored
(src/modules/mavlink/mavlink_receiver.cpp, ``handle_message_set_attitude_target``). The last one is
flown for COM_OF_LOSS_T, then comes what COM_OBL_RC_ACT says (src/modules/commander,
``offboardCheck.cpp``; ``failsafe.cpp``, ``fromOffboardLossActParam``). That failsafe ends by itself
when set-points come again. So none are sent after it, unless it was the link that was dead: then
inert ones are, which hold bank and height, until OFFBOARD is there again. A pilot who has changed
the mode is not overridden by them.

What PX4's parameters allow is the envelope of the controller, and what speaks against a flight.
In OFFBOARD with attitudes PX4 keeps none of its limits of bank, pitch, thrust and airspeed itself,
for the modules that know them do not run (src/modules/commander/ModeUtil/control_mode.cpp,
``getVehicleControlMode``; src/modules/fw_mode_manager, fw_lateral_longitudinal_control): the link
does, by what is read here.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, quaternion_from_euler
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links.mavlink.dialect import CURRENT_MODE, mavlink
from uav_tracking_mpc.links.mavlink.energy_law import EnergyLaw, EnergyLimits, FlownPath
from uav_tracking_mpc.links.mavlink.engagement import State
from uav_tracking_mpc.links.mavlink.findings import (
    BANK_KEPT,
    RATE_SHARE,
    HomeFence,
    VehicleEnvelope,
    applying,
    climb_angle,
    known,
)
from uav_tracking_mpc.links.mavlink.listener import FIXED_WING
from uav_tracking_mpc.links.mavlink.mavlink_link import MavlinkLink
from uav_tracking_mpc.links.mavlink.telemetry import Attitude

# -, %, m/s, m/s^2, deg, s, as fw_*_params.c has them: what PX4 does where a parameter is not sent.
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
FORCE_SHARE = 0.25  # -, of the engine's excess, that is left at the greatest airspeed at least
FREE_THRUST_SLEW = 2.0  # 1/s, where PX4 limits none
LOSS_ACTIONS = {
    0: "Position", 1: "Altitude", 2: "Stabilized", 3: "Return", 4: "Land", 5: "Hold",
    6: "Terminate", 7: "Disarm",
}  # of COM_OBL_RC_ACT: failsafe.cpp, fromOffboardLossActParam  # fmt: skip
ENDS_WELL = (3.0, 5.0)  # codes of COM_OBL_RC_ACT: Return, Hold
LONGEST_LOSS, SHORTEST_LOSS = 5.0, 0.3  # s, of COM_OF_LOSS_T
OFFBOARD_BIT = 4  # bit of COM_RCL_EXCEPT
FATAL = {5: "terminates the flight", 6: "disarms"}  # of NAV_RCL_ACT and NAV_DLL_ACT
FENCE_TERMINATES = 4.0  # code of GF_ACTION


class Px4Envelope(VehicleEnvelope):
    """Limits that the link keeps for PX4.

    Parameters that this version does not have count as their defaults, where that harms nobody.

    Args:
        vehicle: Its parameters by name, in their own units [SI or deg].
        true_over_equivalent: True over equivalent airspeed where it flies [-].
    """

    names, cruise_name, defaults = NAMES, "FW_AIRSPD_TRIM", DEFAULTS

    def values(self, airspeed: float) -> dict[str, Any]:
        """See :meth:`VehicleEnvelope.values`."""
        vehicle, bank = self.assumed, self.bank_max(airspeed)
        least, most = (self.ratio * v for v in self.told("FW_AIRSPD_MIN", "FW_AIRSPD_MAX"))
        climb, sink, idle = (vehicle[f"FW_T_{n}"] for n in ("CLMB_MAX", "SINK_MAX", "SINK_MIN"))
        # Thrust less drag at the ends of the airspeed, the drag growing with its square.
        cruise = math.nan if self.cruise is None else self.cruise
        fast = max(climb - idle * ((most / cruise) ** 2 - 1.0), FORCE_SHARE * climb)
        per_climb = GRAVITY / cruise
        return known(
            {
                "bank_max": math.nan if bank is None else bank - BANK_KEPT,
                "roll_rate_max": RATE_SHARE * self.roll_slew,
                "pitch_rate_max": vehicle["FW_T_VERT_ACC"] / airspeed,
                "path_angle_max": climb_angle(climb, airspeed),
                "path_angle_min": climb_angle(-sink, airspeed),
                "airspeed_min": least,
                "airspeed_max": most,
                "force_max": (per_climb * climb, per_climb * fast),
                "force_min": (-per_climb * idle, -per_climb * idle),
            }
        )

    def bank_max(self, airspeed: float) -> float | None:
        """See :meth:`VehicleEnvelope.bank_max`: what is ever commanded.

        The least airspeed of a turn grows with the root of its load factor
        (src/lib/fw_performance_model, ``PerformanceModel::getMinimumCalibratedAirspeed``).

        Args:
            airspeed: True, in [m/s].
        """
        limit, slowest = self.told("FW_R_LIM", "FW_AIRSPD_MIN")
        return self.turning(limit, airspeed, slowest)

    @property
    def roll_slew(self) -> float:
        """How quickly the commanded bank changes at most in [rad/s]."""
        return math.radians(min(self.assumed["FW_R_RMAX"], self.assumed["FW_PN_R_SLEW_MAX"]))

    def energy_limits(self) -> EnergyLimits:
        """What the energy law is to know and to keep."""
        vehicle = self.assumed
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
        """See :meth:`VehicleEnvelope.fence`."""
        bounds = self.told("GF_MAX_VER_DIST", "GF_MAX_HOR_DIST")
        highest, radius = (bound if bound > 0.0 else math.inf for bound in bounds)
        if not self.vehicle.get("GF_ACTION") or highest == radius == math.inf:
            return None
        return HomeFence(-math.inf, highest, radius).kept

    def refusals(self) -> list[str]:
        """See :meth:`VehicleEnvelope.refusals`."""
        vehicle = self.vehicle
        kind, action = vehicle.get("MAV_TYPE", 1.0), vehicle.get("COM_OBL_RC_ACT", ENDS_WELL[0])
        slow, cruise, fast, loss = self.told(*NEEDED[1:], "COM_OF_LOSS_T")
        low, trim, high = (self.assumed[f"FW_THR_{end}"] for end in ("MIN", "TRIM", "MAX"))
        return [f"{name} cannot be read" for name in NEEDED if name not in vehicle] + applying(
            (
                kind not in FIXED_WING,
                f"MAV_TYPE is {kind:g}: its thrust would be another vehicle's, must be 1 (fixed "
                "wing)",
            ),
            (
                vehicle.get("MAV_FWDEXTSP", 1.0) != 1.0,
                "MAV_FWDEXTSP is 0: it drops a companion's set-points, must be 1",
            ),
            (
                action not in ENDS_WELL,
                f"COM_OBL_RC_ACT is {action:g} ({LOSS_ACTIONS.get(int(action), 'unknown')}): where "
                "the companion falls silent it must end in 5 (Hold) or 3 (Return)",
            ),
            (
                loss < SHORTEST_LOSS or loss > LONGEST_LOSS,
                f"COM_OF_LOSS_T is {loss:g} s: the last attitude and thrust are held that long "
                f"when the companion falls silent, must be from {SHORTEST_LOSS:g} to "
                f"{LONGEST_LOSS:g} s",
            ),
            (
                not 0.0 <= low < trim < high <= 1.0,
                f"FW_THR_TRIM is {trim:g}, must be between FW_THR_MIN = {low:g} and FW_THR_MAX = "
                f"{high:g}, from 0 to 1",
            ),
            (
                slow <= 0.0 or slow >= cruise or cruise >= fast,
                f"FW_AIRSPD_TRIM is {cruise:g} m/s, must be between FW_AIRSPD_MIN = {slow:g} and "
                f"FW_AIRSPD_MAX = {fast:g} m/s",
            ),
        )

    def warnings(self, telemetry_rate: float) -> list[str]:
        """See :meth:`VehicleEnvelope.warnings`."""
        vehicle = self.vehicle
        radio, ground = (int(vehicle.get(f"NAV_{n}_ACT", 0.0)) for n in ("RCL", "DLL"))
        exceptions, fence = vehicle.get("COM_RCL_EXCEPT", 0.0), self.fence()
        unread = "{} cannot be read: see what PX4 does when the companion dies"
        lost = "{} is {}: the loss of the {} {}, 2 (Return) would not"
        return applying(
            *(
                (name not in vehicle, unread.format(name))
                for name in ("COM_OBL_RC_ACT", "COM_OF_LOSS_T")
            ),
            (
                bool(int(exceptions) & OFFBOARD_BIT),
                f"COM_RCL_EXCEPT is {exceptions:g}: OFFBOARD goes on without the pilot's "
                "transmitter, who then cannot take over; without bit 2 it would not",
            ),
            *(
                (action in FATAL, lost.format(name, action, whose, FATAL.get(action)))
                for name, action, whose in (
                    ("NAV_RCL_ACT", radio, "transmitter"),
                    ("NAV_DLL_ACT", ground, "ground station"),
                )
            ),
            (
                bool(vehicle.get("NAV_DLL_ACT")),
                f"NAV_DLL_ACT is {vehicle.get('NAV_DLL_ACT', 0.0):g}: OFFBOARD ends "
                f"{vehicle.get('COM_DL_LOSS_T', 10.0):g} s after the last heartbeat of a ground "
                "station, which a companion's does not replace",
            ),
            (
                fence is None,
                "GF_ACTION, GF_MAX_HOR_DIST and GF_MAX_VER_DIST set no fence of the autopilot's "
                "own",
            ),
            (
                fence is not None and vehicle.get("GF_ACTION") == FENCE_TERMINATES,
                "GF_ACTION is 4: a breach of the fence terminates the flight",
            ),
            (
                vehicle.get("FW_USE_AIRSPD", 1.0) == 0.0,
                "FW_USE_AIRSPD is 0: the attitude loops take every airspeed for FW_AIRSPD_TRIM",
            ),
            (
                bool(vehicle.get("MAV_SIGN_CFG")),
                "MAV_SIGN_CFG is on: only messages signed with its key are heard",
            ),
        )


# Codes of main and sub mode of custom_mode: src/modules/commander/px4_custom_mode.h
MODES = {
    (1, 0): "MANUAL", (2, 0): "ALTITUDE", (3, 0): "POSITION", (3, 2): "POSITION", (4, 1): "READY",
    (4, 2): "TAKEOFF", (4, 3): "HOLD", (4, 4): "MISSION", (4, 5): "RETURN", (4, 6): "LAND",
    (4, 8): "FOLLOW_TARGET", (4, 9): "PRECLAND", (4, 10): "VTOL_TAKEOFF", (5, 0): "ACRO",
    (6, 0): "OFFBOARD", (7, 0): "STABILIZED", (10, 0): "TERMINATION", (11, 0): "ALTITUDE_CRUISE",
}  # fmt: skip
OFFBOARD, HOLD = (6, 0), (4, 3)
NO_RATES = 0b111  # type_mask; rates are ignored; attitude and thrust are not
CUSTOM_MODE = 1.0  # code: param1 of DO_SET_MODE
INERT_TIME = 1.2  # s of inert set-points before OFFBOARD is asked for; PX4 wants more than 1 s
FENCE_PERIOD = 0.5  # s between looks at the fence
STALE = 1.0  # s that the newest measurement may be old


def main_and_sub(custom_mode: int) -> tuple[int, int]:
    """Main and sub mode.

    Args:
        custom_mode: Of HEARTBEAT or CURRENT_MODE.
    """
    return custom_mode >> 16 & 0xFF, custom_mode >> 24 & 0xFF


class Px4Link(MavlinkLink):
    """PX4 with a fixed wing, which is asked for its mode OFFBOARD."""

    name = "px4"
    title = "PX4"
    when_silent = (
        "holds its last attitude and thrust for COM_OF_LOSS_T, then goes to Hold or Return as "
        "COM_OBL_RC_ACT says"
    )
    autopilot = mavlink.MAV_AUTOPILOT_PX4
    handed_over = ("HOLD", "MISSION", "POSITION", "OFFBOARD")
    limits = Px4Envelope
    by_bits = True
    slow_messages = (mavlink.MAVLINK_MSG_ID_WIND_COV, mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS)
    quick_messages = (CURRENT_MODE,)
    stream_period = 0.02

    def _forget(self) -> None:
        super()._forget()
        self._law: EnergyLaw | None = None
        self._bank, self._banked_at = 0.0, -math.inf
        self._inert_since: float | None = None

    def mode_name(self, custom_mode: int) -> str:
        """See :meth:`MavlinkLink.mode_name`."""
        main, sub = main_and_sub(custom_mode)
        return MODES.get((main, sub), f"number {main}.{sub}")

    def takes_commands(self, custom_mode: int) -> bool:
        """See :meth:`MavlinkLink.takes_commands`."""
        return main_and_sub(custom_mode)[0] == OFFBOARD[0]

    def envelope(self) -> Px4Envelope:
        """See :meth:`MavlinkLink.envelope`."""
        return Px4Envelope(self.vehicle, self.ratio)

    def ask_for_command(self, now: float) -> None:
        """See :meth:`MavlinkLink.ask_for_command`: once set-points have come for long enough."""
        if self._inert_since is not None and now - self._inert_since >= INERT_TIME:
            self._set_mode(now, OFFBOARD, "the mode OFFBOARD")

    def _set_mode(self, now: float, mode: tuple[int, int], words: str) -> None:
        command = mavlink.MAV_CMD_DO_SET_MODE
        self.heard.requests.ask(now, command, words, CUSTOM_MODE, *map(float, mode))

    def begin(self, now: float) -> None:
        """See :meth:`MavlinkLink.begin`: the law goes on from what is flown."""
        self._inert_since = None
        telemetry = self.heard.telemetry
        attitude, measured = telemetry.attitude, telemetry.newest
        airspeed = telemetry.flown_airspeed
        self._law = EnergyLaw(self.envelope().energy_limits())
        if attitude is not None and measured is not None and airspeed is not None:
            flown = self._flown(attitude, measured, airspeed, now)
            self._law.begin(flown, attitude.pitch, telemetry.throttle)
            self._bank, self._banked_at = attitude.roll, now

    def accompany(self, now: float) -> None:
        """See :meth:`MavlinkLink.accompany`: command is given back where the orbit is refused."""
        if self.orbit is None or not self.heard.is_due("fence", now, FENCE_PERIOD):
            return
        if refusal := self.refusal(self.orbit):
            self.engagement.give_up(refusal)
            self.let_go(now)

    def let_go(self, now: float) -> None:
        """See :meth:`MavlinkLink.let_go`."""
        self._set_mode(now, HOLD, "the mode Hold")

    def fly(self, inputs: NDArray[np.float64], measured: Measurement, now: float) -> None:
        """See :meth:`MavlinkLink.fly`."""
        telemetry = self.heard.telemetry
        attitude, airspeed = telemetry.attitude, telemetry.flown_airspeed
        if attitude is None or airspeed is None or now - measured.stamp > STALE:
            return  # without these nothing is flown blindly: PX4 does as when we are silent
        if self._law is None:
            self.begin(now)
        assert self._law is not None
        turn_rate, path_rate, gain = np.asarray(inputs, dtype=float).tolist()
        envelope = self.envelope()
        limit, reach = envelope.bank_max(airspeed) or 0.0, envelope.roll_slew
        coordinated = turn_rate - telemetry.surplus
        wanted = _clip(bank_from_turn_rate(coordinated, airspeed), limit)
        change = _clip(wanted - self._bank, reach * (now - self._banked_at))
        self._bank, self._banked_at = _clip(self._bank + change, limit), now
        flown = self._flown(attitude, measured, airspeed, now)
        pitch, thrust = self._law.step(path_rate, gain, flown)
        self._send(self._bank, pitch, thrust, attitude)

    def _hold(self, now: float) -> None:
        """Send an inert set-point: bank, height and thrust as they are."""
        telemetry = self.heard.telemetry
        attitude, measured = telemetry.attitude, telemetry.newest
        if attitude is None or measured is None or now - measured.stamp > STALE:
            self._inert_since = None
            return
        self._inert_since = self._inert_since or now
        self._sent_at = now
        envelope = self.envelope()
        limits = envelope.energy_limits()
        limit = envelope.bank_max(telemetry.flown_airspeed or 0.0) or 0.0
        pitch = attitude.pitch - measured.path_angle
        thrust = limits.trim if telemetry.throttle is None else telemetry.throttle
        self._send(
            _clip(attitude.roll, limit),
            min(max(pitch, limits.pitch_min), limits.pitch_max),
            min(max(thrust, limits.thrust_min), limits.thrust_max),
            attitude,
        )

    def _send(self, bank: float, pitch: float, thrust: float, attitude: Attitude) -> None:
        self.heard.connection.send(
            mavlink.MAVLink_set_attitude_target_message(
                self.heard.connection.boot_time, self.heard.system, 1, NO_RATES,
                quaternion_from_euler(bank, pitch, attitude.yaw), 0.0, 0.0, 0.0, thrust,
            )
        )  # fmt: skip

    def _flown(
        self, attitude: Attitude, measured: Measurement, airspeed: float, now: float
    ) -> FlownPath:
        return FlownPath(now, measured.path_angle, airspeed, attitude.roll, self.ratio)

    @property
    def _streams(self) -> bool:
        # A pilot who may hand over finds set-points that stream, but not after a failsafe.
        if self.engagement.state is not State.IDLE:
            return True
        heartbeat = self.heard.heartbeat
        waits = (
            self.parameters.engage_on_mode
            and heartbeat is not None
            and self.heard.armed
            and not self.takes_commands(heartbeat.custom_mode)
            and heartbeat.system_status != mavlink.MAV_STATE_CRITICAL
        )
        if not waits:
            self._inert_since = None
        return bool(waits)

    def _fly(self, now: float) -> None:
        if self.engagement.commanding:
            super()._fly(now)
        else:
            self._hold(now)

    def _see(self, message: Any, arrival: float) -> None:
        """See :class:`MavlinkLink`: CURRENT_MODE ends our commands, but begins none."""
        super()._see(message, arrival)
        if message.get_type() == "CURRENT_MODE" and not self.takes_commands(message.custom_mode):
            # Where a failsafe flies, OFFBOARD is still what the pilot wants.
            failsafe = self.takes_commands(message.intended_custom_mode)
            self._see_mode(message.custom_mode, arrival, failsafe)


def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)
