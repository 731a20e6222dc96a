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

"""PX4 fixed wing, as it behaves towards a companion computer.

Files and functions named here are those of PX4 (PX4/PX4-Autopilot, 1.15 to main). There is no
manual control: modes that follow sticks fly wings level, as with sticks that stay centred.
Parameters and rates are those of 1.16 that matter to a companion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from uav_tracking_mpc.autopilot.airframe import STEEPEST
from uav_tracking_mpc.autopilot.autopilot_core import (
    AttitudeTarget,
    AutopilotCore,
    BaseMode,
    Cmd,
    Order,
    Result,
    Severity,
    Traits,
    VehicleNumbers,
)
from uav_tracking_mpc.autopilot.flight_loops import TICK, Demand, Loiter, Response
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.px4 import DEFAULTS

LOITER_RADIUS = 80  # m, NAV_LOITER_RAD where the aircraft is slow enough for it
# Hz, mavlink_main.cpp, configure_streams_to_default, MAVLINK_MODE_ONBOARD
STREAM_RATES = {
    "GLOBAL_POSITION_INT": 50.0, "ATTITUDE": 100.0, "VFR_HUD": 10.0,
    "WIND_COV": 10.0, "ESTIMATOR_STATUS": 1.0, "SYS_STATUS": 5.0,
    "GPS_RAW_INT": 10.0, "EXTENDED_SYS_STATE": 5.0,
    "HOME_POSITION": 0.5, "CURRENT_MODE": 0.5,
}  # fmt: skip


SLOWEST_STREAM = 0.5  # s between set-points, 2 Hz: documentation of the mode Offboard
ATTITUDE_BIT, THROTTLE_BIT, RATE_BITS = 0b10000000, 0b01000000, 0b00000011  # of type_mask
AUTO, MAIN_SHIFT, SUB_SHIFT = 4, 16, 24  # code and shifts by bits, px4_custom_mode.h
BY_STICKS = ("MANUAL", "STABILIZED", "ALTCTL", "POSCTL")


class Px4(AutopilotCore):
    """Flies a plant as PX4 does.

    The limits of speed, climb and bank come from the configuration, the other parameters have
    PX4's own defaults.
    """

    modes: ClassVar[Mapping[str, int]] = {
        "MANUAL": 1 << MAIN_SHIFT,
        "ALTCTL": 2 << MAIN_SHIFT,
        "POSCTL": 3 << MAIN_SHIFT,
        "TAKEOFF": AUTO << MAIN_SHIFT | 2 << SUB_SHIFT,
        "LOITER": AUTO << MAIN_SHIFT | 3 << SUB_SHIFT,
        "RTL": AUTO << MAIN_SHIFT | 5 << SUB_SHIFT,
        "OFFBOARD": 6 << MAIN_SHIFT,
        "STABILIZED": 7 << MAIN_SHIFT,
    }
    loiter_mode, ground_mode, take_off_mode = "LOITER", "LOITER", "TAKEOFF"
    traits = Traits(
        mode_flags={  # streams/HEARTBEAT.hpp, ``get_px4_mode``
            **dict.fromkeys(modes, BaseMode.AUTO_ENABLED | BaseMode.GUIDED_ENABLED),
            **dict.fromkeys(BY_STICKS, BaseMode.MANUAL_INPUT_ENABLED),
            "OFFBOARD": 0,
        },
        meanings={
            "slowest": "FW_AIRSPD_MIN",
            "fastest": "FW_AIRSPD_MAX",
            "climb_max": "FW_T_CLMB_MAX",
            "climb_held": "FW_T_CLMB_R_SP",
            "sink_held": "FW_T_SINK_R_SP",
            "sink_idle": "FW_T_SINK_MIN",
            "load_energy": "FW_T_RLL2THR",
            "height_time": "FW_T_ALT_TC",
            "airspeed_time": "FW_T_TAS_TC",
        },
        maker=mavlink.MAV_AUTOPILOT_PX4,
        version=(1, 16, 0),
        # MISSION_FLOAT, MISSION_INT, COMMAND_INT, PARAM_ENCODE_BYTEWISE, SET_ATTITUDE_TARGET,
        # SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT, MAVLINK2
        capabilities=1 | 4 | 8 | 16 | 64 | 128 | 256 | 8192,
        stream_rates=STREAM_RATES,
        mode_messages=(),  # streams/HEARTBEAT.hpp: a constant rate, whatever happens
        lacking=("EKF_STATUS_REPORT", "POSITION_TARGET_GLOBAL_INT", "WIND"),
        sync_period=0.1,
        unknown_message=Result.DENIED,
        mode_refused=Result.TEMPORARILY_REJECTED,
        hears_all=False,  # Commander.cpp, evaluate_target_ok
        bytewise=True,
        set_mode_acknowledged=Cmd.DO_SET_MODE,  # into which it is turned
    )
    least_interval = TICK  # streams are as quick as their data
    _intended: str  # user_mode_intention: goes on where a failsafe is over
    _target: AttitudeTarget | None = None
    _last, _before = -math.inf, -math.inf  # when the two newest set-points came, in s

    @classmethod
    def defaults(cls, own: VehicleNumbers) -> dict[str, float]:
        """See :meth:`AutopilotCore.defaults`; an integer is one of PX4's too."""
        return {
            **DEFAULTS,
            "COM_DL_LOSS_T": 10,
            # Hold: as it is to be set; PX4's own default 0 is refused by the link
            "COM_OBL_RC_ACT": 5,
            "COM_OF_LOSS_T": 1.0,
            "COM_RCL_EXCEPT": 0,
            "FW_AIRSPD_MAX": round(own.fastest, 2),
            "FW_AIRSPD_MIN": round(own.slowest, 2),
            "FW_AIRSPD_TRIM": own.cruise,
            "FW_R_LIM": own.bank_max,
            "FW_R_RMAX": float(own.roll_rate),
            "FW_R_TC": 0.4,
            "FW_T_ALT_TC": 5.0,
            "FW_T_CLMB_MAX": own.climb_max,
            "FW_T_CLMB_R_SP": min(3.0, own.climb_max),
            "FW_T_SINK_MAX": own.sink_max,
            "FW_T_SINK_MIN": own.sink_idle,
            "FW_T_SINK_R_SP": min(2.0, own.sink_max),
            "FW_T_TAS_TC": 5.0,
            "FW_USE_AIRSPD": 1,
            "GF_ACTION": 2,
            "GF_MAX_HOR_DIST": 0.0,
            "GF_MAX_VER_DIST": 0.0,
            "MAV_FWDEXTSP": 1,
            "MAV_TYPE": 1,
            "MIS_TAKEOFF_ALT": 30.0,
            "NAV_DLL_ACT": 0,
            "NAV_LOITER_RAD": float(max(LOITER_RADIUS, own.radius)),
            "NAV_RCL_ACT": 2,
            "NPFG_DAMPING": 0.7,
            "NPFG_PERIOD": 10.0,
            "RTL_LOITER_RAD": float(max(LOITER_RADIUS, own.radius)),
            "RTL_RETURN_ALT": 60.0,
        }

    def restart(self) -> None:
        """See :meth:`AutopilotCore.restart`; who streamed before is not known any more."""
        self._last = self._before = -math.inf
        super().restart()

    @property
    def intended_custom_mode(self) -> int:
        """See :attr:`AutopilotCore.intended_custom_mode`."""
        return self.modes[self._intended]

    @property
    def trim(self) -> float:
        """PerformanceModel.cpp, ``getTrimThrottle``: in thinner air it takes more of it."""
        return self.parameters["FW_THR_TRIM"] * self.density_factor

    @property
    def roll_response(self) -> Response:
        """FW_R_TC and FW_R_RMAX; FW_R_LIM is no limit of a set-point from outside.

        It lives in the mode manager, which does not run in OFFBOARD by attitude.
        """
        known = self.parameters
        # fw_yaw_controller.cpp: a turn is made of no more bank than that.
        limit = STEEPEST if self.mode == "OFFBOARD" else math.radians(known["FW_R_LIM"])
        return Response(limit, max(known["FW_R_TC"], 0.1), math.radians(known["FW_R_RMAX"]))

    def mode_order(self, base_mode: int, custom_mode: int) -> Order:
        """See :meth:`AutopilotCore.mode_order`: the packed number is taken apart."""
        main, sub = custom_mode >> MAIN_SHIFT & 0xFF, custom_mode >> SUB_SHIFT & 0xFF
        return Order(Cmd.DO_SET_MODE, float(base_mode), float(main), float(sub))

    @property
    def _streaming(self) -> bool:
        """offboardCheck.cpp, ``checkAndReport``; 2 Hz and more are documented."""
        steady = self._last - self._before < SLOWEST_STREAM
        return steady and self.time - self._last < self.parameters["COM_OF_LOSS_T"]

    def set_mode(self, mode: str) -> bool:
        """See :meth:`AutopilotCore.set_mode`; UserModeIntention.cpp, ``change``."""
        if not super().set_mode(mode):
            return False
        self._intended, self.failsafe = mode, False
        return True

    def may_enter(self, mode: str) -> bool:
        """See :meth:`AutopilotCore.may_enter`: a mode that cannot run, only while disarmed."""
        if mode == "OFFBOARD" and self.armed and not self._streaming:
            self.say(Severity.CRITICAL, "Switching to Offboard is currently not possible")
            return False
        return True

    def enter(self, mode: str) -> None:
        """See :meth:`AutopilotCore.enter`."""
        known = self.parameters
        self._target = None
        self.loiter = self.loiter_here(known["NAV_LOITER_RAD"])
        if not self.failsafe:
            self._intended = mode
        if mode == "RTL":  # rtl.cpp: home, at RTL_RETURN_ALT above it where it is lower
            up = max(self.state.up, known["RTL_RETURN_ALT"])
            self.loiter = Loiter(0.0, 0.0, up, known["RTL_LOITER_RAD"])
        elif mode == "TAKEOFF":
            up = max(known["MIS_TAKEOFF_ALT"], self.state.up)
            self.loiter = self.loiter._replace(up=up)

    def watch(self) -> None:
        """failsafe.cpp, ``checkStateAndMode``: set-points, then the ground station."""
        if not self.airframe.flying:
            return
        known = self.parameters
        if self._intended == "OFFBOARD":
            if self.failsafe and self._streaming:
                # The intention was OFFBOARD all the while: it goes on without being asked.
                self.failsafe = False
                self.mode = "OFFBOARD"
                self.enter("OFFBOARD")
            elif not self.failsafe and self.time - self._last >= known["COM_OF_LOSS_T"]:
                self._fail("Offboard control lost", int(known["COM_OBL_RC_ACT"]) == 5)
        heard, action = self.ground_heard, int(known["NAV_DLL_ACT"])
        if heard is None or action == 0 or self.failsafe or self.mode == "RTL":
            return
        if self.time - heard > known["COM_DL_LOSS_T"]:
            self.ground_heard = None
            self._intended = "RTL"
            self._fail("Connection to ground station lost", action == 1)

    def _fail(self, words: str, holds: bool) -> None:
        """Hold, or Return: what needs sticks, of which there are none, ends there too."""
        self.failsafe = True
        self.mode = "LOITER" if holds else "RTL"
        self.enter(self.mode)
        self.say(Severity.CRITICAL, f"Failsafe: {words}")

    def demand(self) -> Demand:
        """What the present mode asks for."""
        known, loops, target = self.parameters, self.loops, self._target
        if self.mode in ("MANUAL", "STABILIZED"):
            return loops.wings_level(known["FW_P_TC"], self.engine)
        if self.mode == "OFFBOARD" and target is not None:
            # FixedwingAttitudeControl.cpp, Run: as it comes, with no limit of the mode manager
            lag = max(known["FW_P_TC"], 0.1)
            steepest = math.radians(known["FW_P_RMAX_POS"])
            climb = min(max(loops.by_pitch(target.pitch, lag), -steepest), steepest)
            return Demand(target.roll, climb, loops.by_throttle(target.thrust, self.engine))
        # lib/tecs/TECS.cpp; PerformanceModel.cpp, ``getMinimumCalibratedAirspeed``
        climb, acceleration = self.hold(self.loiter.up, known["FW_AIRSPD_TRIM"])
        if self.mode in (*BY_STICKS, "OFFBOARD"):
            return Demand(0.0, climb, acceleration)
        roll = loops.bank_to(self.loiter, known["NPFG_PERIOD"], known["NPFG_DAMPING"])
        if self.mode == "TAKEOFF" and self.state.up < self.loiter.up - 5.0:
            roll = 0.0  # straight on along the runway
            self.loiter = self.loiter_here(known["NAV_LOITER_RAD"])._replace(up=self.loiter.up)
        return Demand(roll, climb, acceleration)

    def attitude_target(self, target: AttitudeTarget) -> None:
        """See :meth:`AutopilotCore.attitude_target`.

        mavlink_receiver.cpp, ``handle_message_set_attitude_target``: whatever the mode, it proves
        that somebody streams; it is flown in OFFBOARD, and no thrust is a thrust of zero.
        """
        attitude = not target.mask & ATTITUDE_BIT
        if not self.parameters["MAV_FWDEXTSP"] or not (attitude or not target.mask & RATE_BITS):
            return
        self._before, self._last = self._last, self.time
        if self.mode == "OFFBOARD" and attitude:
            thrust = 0.0 if target.mask & THROTTLE_BIT else target.thrust
            self._target = target._replace(thrust=thrust)

    def _set_mode(self, order: Order) -> int:
        main, sub = int(order.param2), int(order.param3)
        if not int(order.param1) & BaseMode.CUSTOM_MODE_ENABLED:
            return Result.TEMPORARILY_REJECTED
        number = main << MAIN_SHIFT | (sub << SUB_SHIFT if main == AUTO else 0)
        name = self.mode_numbered(number)
        if name is None:  # an unknown main mode changes nothing, and is acknowledged
            return Result.TEMPORARILY_REJECTED if main == AUTO else Result.ACCEPTED
        return self.changed(self.set_mode(name))

    def _reposition(self, order: Order) -> int:
        """``handle_command``: bit 0 must be asked for; the altitude is above sea level."""
        if order.param2 != 1.0:
            return Result.UNSUPPORTED
        state = self.state
        here = self.origin.place(state.place)
        latitude = math.radians(order.x) if math.isfinite(order.x) else here[0]
        longitude = math.radians(order.y) if math.isfinite(order.y) else here[1]
        altitude = order.z if math.isfinite(order.z) else here[2]
        if abs(latitude) > 0.5 * math.pi or abs(longitude) > math.pi:
            return Result.DENIED
        self.set_mode("LOITER")
        east, north, up = self.origin.position(latitude, longitude, altitude).tolist()
        radius = order.param3
        if not math.isfinite(radius) or radius == 0.0:
            radius = self.parameters["NAV_LOITER_RAD"]
        self.loiter = Loiter(east, north, up, radius)
        return Result.ACCEPTED

    def _arm(self, order: Order) -> int:
        if order.param1 not in (0.0, 1.0):
            return Result.UNSUPPORTED
        if order.param1 == 0.0 and self.airframe.flying:
            return Result.TEMPORARILY_REJECTED  # Disarming denied: not landed
        if order.param1 == 1.0 and self.mode == "OFFBOARD" and not self._streaming:
            return Result.TEMPORARILY_REJECTED
        self.armed = order.param1 == 1.0
        return Result.ACCEPTED

    answers: ClassVar = {  # Commander.cpp, handle_command
        Cmd.DO_SET_MODE: _set_mode,
        Cmd.DO_REPOSITION: _reposition,
        Cmd.COMPONENT_ARM_DISARM: _arm,
    }
    mode_commands: ClassVar = {
        Cmd.NAV_LOITER_UNLIM: "LOITER",
        Cmd.NAV_RETURN_TO_LAUNCH: "RTL",
        Cmd.NAV_TAKEOFF: "TAKEOFF",
    }
