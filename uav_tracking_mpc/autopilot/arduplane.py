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

"""ArduPlane, as it behaves towards a companion computer.

Files and functions named here are those of ArduPilot (ArduPilot/ardupilot, 4.6 to 4.7-dev); ``P/``
is its folder ``ArduPlane``. Pilots' sticks stay centred: modes that follow them fly wings level.
Parameters and rates are those of 4.6 that matter to a companion.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

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
from uav_tracking_mpc.autopilot.flight_loops import Demand, Loiter, Response
from uav_tracking_mpc.links.mavlink.dialect import mavlink

LOITER_RADIUS = 60  # m, WP_LOITER_RAD where the aircraft is slow enough for it

# Hz, SRx_POSITION, _EXTRA1 to _EXTRA3, _EXT_STAT as ground stations set them
STREAM_RATES = {
    "GLOBAL_POSITION_INT": 4.0, "ATTITUDE": 10.0, "VFR_HUD": 10.0,
    "WIND": 4.0, "EKF_STATUS_REPORT": 4.0, "SYS_STATUS": 4.0,
    "GPS_RAW_INT": 4.0,
}  # fmt: skip


STALE_ALTITUDE = 0.1  # s for which a new guided point leaves TECS with the altitude of now
ATTITUDE_BIT, THROTTLE_BIT = 0b10000000, 0b01000000  # of type_mask
AXIS_BITS = {"roll": 0b001, "pitch": 0b010, "yaw": 0b100}  # bits of type_mask


class Guided:
    """P/Plane.h, ``guided_state``; a mode change begins a new one (P/mode.cpp, ``Mode::enter``).

    Attributes:
        radius: Of the loiter in [m]; 0 for WP_LOITER_RAD.
        moved: When the guided point was last set in [s].
        up: Height in ``map`` in [m] that GUIDED_CHANGE_ALTITUDE asks for; None without one.
        speed: Calibrated airspeed of GUIDED_CHANGE_SPEED in [m/s]; None without one.
    """

    def __init__(self) -> None:
        self.radius, self.moved = 0.0, -math.inf
        self.up: float | None = None
        self.speed: float | None = None
        self._forced: dict[str, tuple[float, float]] = {}  # value and since when, by axis

    def force(self, target: AttitudeTarget, now: float) -> None:
        """P/GCS_MAVLink_Plane.cpp, ``handle_set_attitude_target``.

        Where the attitude is not left out all three axes are forced, whatever the bits of the
        rates say.

        Args:
            target: The message.
            now: In [s].
        """
        taken = ~target.mask & 0xFF
        values = {"roll": target.roll, "pitch": target.pitch, "yaw": 0.0}
        for axis, bit in AXIS_BITS.items():
            if taken & (ATTITUDE_BIT | bit):
                self._forced[axis] = (values[axis], now)
        if taken & THROTTLE_BIT:
            self._forced["throttle"] = (target.thrust, now)

    def value(self, axis: str, now: float, memory: float) -> float | None:
        """What is forced on an axis, roll and pitch in [rad]; None where nothing is, or not now.

        Args:
            axis: ``roll``, ``pitch``, ``yaw`` or ``throttle``.
            now: In [s].
            memory: For how long it is forced in [s].
        """
        value, since = self._forced.get(axis, (0.0, -math.inf))
        return value if now - since < memory else None


LEAST_LOAD_LIMIT = math.radians(25.0)  # rad, P/Attitude.cpp, apply_load_factor_roll_limits
PITCH_LAG = 0.5  # s, PTCH2SRV_TCONST
SPEED_TYPE_AIRSPEED = 0  # code of DO_CHANGE_SPEED
REPOSITION_CHANGES_MODE = 1  # flag MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
FORCED_ARMING = 2989.0  # code of MAV_CMD_COMPONENT_ARM_DISARM, P/AP_Arming.cpp


class ArduPlane(AutopilotCore):
    """Flies a plant as ArduPlane does.

    Its loiter radius and the limits of speed, climb and bank come from the configuration, the
    other parameters have ArduPlane's own defaults.
    """

    modes: ClassVar[Mapping[str, int]] = {  # P/mode.h, Mode::Number
        "MANUAL": 0, "CIRCLE": 1, "STABILIZE": 2, "FBWA": 5, "FBWB": 6, "CRUISE": 7, "RTL": 11,
        "LOITER": 12, "TAKEOFF": 13, "GUIDED": 15,
    }  # fmt: skip
    loiter_mode, ground_mode, take_off_mode = "LOITER", "FBWA", "TAKEOFF"
    traits = Traits(
        # P/GCS_MAVLink_Plane.cpp, ``GCS_MAVLINK_Plane::base_mode``
        mode_flags={
            **dict.fromkeys(modes, BaseMode.MANUAL_INPUT_ENABLED),
            **dict.fromkeys(
                ("CIRCLE", "RTL", "LOITER", "TAKEOFF", "GUIDED"),
                BaseMode.MANUAL_INPUT_ENABLED | BaseMode.GUIDED_ENABLED,
            ),
        },
        meanings={
            "slowest": "AIRSPEED_MIN",
            "fastest": "AIRSPEED_MAX",
            "climb_max": "TECS_CLMB_MAX",
            "climb_held": "TECS_CLMB_MAX",
            "sink_held": "TECS_SINK_MAX",
            "sink_idle": "TECS_SINK_MIN",
            "load_energy": "TECS_RLL2THR",
            "height_time": "TECS_TIME_CONST",
            "airspeed_time": "TECS_TIME_CONST",
        },
        maker=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
        version=(4, 6, 0),
        # MISSION_FLOAT, PARAM_FLOAT, MISSION_INT, COMMAND_INT, SET_ATTITUDE_TARGET,
        # SET_POSITION_TARGET_GLOBAL_INT, MAVLINK2: P/GCS_MAVLink_Plane.cpp, ``capabilities``
        capabilities=1 | 2 | 4 | 8 | 64 | 256 | 8192,
        stream_rates=STREAM_RATES,
        mode_messages=("HEARTBEAT",),  # P/system.cpp, Plane::set_mode
        lacking=("CURRENT_MODE", "ESTIMATOR_STATUS", "WIND_COV"),
        sync_period=10.0,
        unknown_message=Result.FAILED,
        mode_refused=Result.FAILED,
        hears_all=True,
        bytewise=False,
        set_mode_acknowledged=mavlink.MAVLINK_MSG_ID_SET_MODE,
    )
    _guided: Guided

    @classmethod
    def defaults(cls, own: VehicleNumbers) -> dict[str, float]:
        """See :meth:`AutopilotCore.defaults`; an integer is one of ArduPlane's too."""
        return {
            "AIRSPEED_CRUISE": own.cruise,
            "AIRSPEED_MAX": math.floor(own.fastest),
            "AIRSPEED_MIN": math.ceil(own.slowest),
            "AIRSPEED_STALL": 0.0,
            "ARSPD_USE": 1,
            "FENCE_ACTION": 1,
            "FENCE_ALT_MAX": 100,
            "FENCE_ALT_MIN": -10,
            "FENCE_ENABLE": 0,
            "FENCE_RADIUS": 300,
            "FENCE_TYPE": 4,
            "FS_GCS_ENABL": 0,
            "FS_LONG_ACTN": 0,
            "FS_LONG_TIMEOUT": 5.0,
            "GUIDED_TIMEOUT": 3.0,
            "LEVEL_ROLL_LIMIT": 5,
            "NAVL1_DAMPING": 0.75,
            "NAVL1_PERIOD": 17.0,
            "PTCH_LIM_MAX_DEG": 20.0,
            "PTCH_LIM_MIN_DEG": -25.0,
            "RLL2SRV_RMAX": round(own.roll_rate),
            "RLL2SRV_TCONST": 0.5,
            "ROLL_LIMIT_DEG": own.bank_max,
            "RTL_ALTITUDE": 100.0,
            "RTL_RADIUS": 0,
            "SCHED_LOOP_RATE": 100,
            "STALL_PREVENTION": 1,
            "STICK_MIXING": 1,
            "SYSID_MYGCS": 255,
            "TECS_CLMB_MAX": own.climb_max,
            "TECS_RLL2THR": 10.0,
            "TECS_SINK_MAX": own.sink_max,
            "TECS_SINK_MIN": own.sink_idle,
            "TECS_TIME_CONST": 5.0,
            "TKOFF_ALT": 50,
            "TKOFF_DIST": 200,
            "TKOFF_LVL_ALT": 10,
            "TRIM_THROTTLE": 45,
            "WP_LOITER_RAD": max(LOITER_RADIUS, own.radius),
        }

    @property
    def trim(self) -> float:
        """See :attr:`AutopilotCore.trim`."""
        return 0.01 * self.parameters["TRIM_THROTTLE"]

    @property
    def roll_response(self) -> Response:
        """ROLL_LIMIT_DEG and what the load factor leaves of it, RLL2SRV_TCONST, RLL2SRV_RMAX.

        P/ArduPlane.cpp, ``Plane::ahrs_update``; P/Attitude.cpp, ``apply_load_factor_roll_limits``;
        AP_RollController.cpp, ``get_servo_out``: a rate of 0 is no limit.
        """
        known = self.parameters
        limit = math.radians(known["ROLL_LIMIT_DEG"]) * math.cos(self.state.pitch)
        stall = known["AIRSPEED_STALL"] or known["AIRSPEED_MIN"]
        if known["STALL_PREVENTION"] and stall > 0.0:
            load = max((self.state.airspeed / self.density_factor / stall) ** 2, 1.0)
            limit = min(limit, max(math.acos(1.0 / load), LEAST_LOAD_LIMIT))
        rate = known["RLL2SRV_RMAX"]
        return Response(
            limit=limit,
            lag=max(known["RLL2SRV_TCONST"], 0.1),
            rate=math.radians(rate) if rate > 0.0 else math.inf,
        )

    @property
    def least_interval(self) -> float:
        """0.8 of the main loop's rate at most: GCS_Common.cpp, ``cap_message_interval``."""
        return 1.0 / (0.8 * max(self.parameters["SCHED_LOOP_RATE"], 1.0))

    def enter(self, mode: str) -> None:
        """See :meth:`AutopilotCore.enter`; the modes' own ``_enter`` in P/mode_*.cpp."""
        known = self.parameters
        self._guided = Guided()
        radius = known["WP_LOITER_RAD"]
        self.loiter = self.loiter_here(radius)
        if mode == "RTL":  # P/mode_rtl.cpp, do_RTL: home, at RTL_ALTITUDE above it
            height = known["RTL_ALTITUDE"]
            up = self.state.up if height < 0.0 else height
            self.loiter = Loiter(0.0, 0.0, up, known["RTL_RADIUS"] or radius)
        elif mode == "TAKEOFF":  # P/mode_takeoff.cpp: straight on, then a loiter
            distance, heading = known["TKOFF_DIST"], self.state.heading
            self.loiter = self.loiter._replace(
                east=self.state.east + distance * math.cos(heading),
                north=self.state.north + distance * math.sin(heading),
                up=max(known["TKOFF_ALT"], self.state.up),
            )

    def heard_heartbeat(self, system: int, ground_station: bool) -> None:
        """See :meth:`AutopilotCore.heard_heartbeat`: only SYSID_MYGCS counts, whatever it says."""
        super().heard_heartbeat(system, system == self.parameters["SYSID_MYGCS"])

    def watch(self) -> None:
        """The ground station's loss, P/events.cpp ``failsafe_long_on_event``."""
        known, heard = self.parameters, self.ground_heard
        if heard is None or known["FS_GCS_ENABL"] not in (1, 2):
            self.failsafe = False
            return
        before, self.failsafe = self.failsafe, self.time - heard > known["FS_LONG_TIMEOUT"]
        if before or not self.failsafe or not self.airframe.flying:
            return
        chosen = {1: "RTL", 2: "FBWA"}.get(int(known["FS_LONG_ACTN"]))
        if chosen is None and self.mode not in ("GUIDED", "LOITER"):
            chosen = "RTL"  # modes that a pilot flies always end there
        if chosen is not None and chosen != self.mode:
            self.set_mode(chosen)
            self.say(Severity.WARNING, f"GCS Failsafe On: switched to {chosen}")

    def demand(self) -> Demand:
        """P/mode_guided.cpp ``ModeGuided::update``, and the ``update`` of the other modes."""
        known, loops = self.parameters, self.loops
        if self.mode in ("MANUAL", "STABILIZE", "FBWA"):
            return loops.wings_level(PITCH_LAG, self.engine)
        climb, acceleration = self._tecs()
        if self.mode in ("FBWB", "CRUISE"):
            return Demand(0.0, climb, acceleration)
        if self.mode == "CIRCLE":  # P/mode_circle.cpp: a third of the roll limit
            return Demand(self.roll_response.limit / 3.0, climb, acceleration)
        roll = self._forced("roll")
        if roll is None:
            roll = loops.bank_to(self.loiter, known["NAVL1_PERIOD"], known["NAVL1_DAMPING"])
        if self.mode == "TAKEOFF" and self.state.up < known["TKOFF_LVL_ALT"]:
            level = math.radians(known["LEVEL_ROLL_LIMIT"])
            roll = min(max(roll, -level), level)
        pitch, throttle = self._forced("pitch"), self._forced("throttle")
        if pitch is not None:
            lowest, highest = known["PTCH_LIM_MIN_DEG"], known["PTCH_LIM_MAX_DEG"]
            pitch = min(max(pitch, math.radians(lowest)), math.radians(highest))
            climb = loops.by_pitch(pitch, PITCH_LAG)
        if throttle is not None and known["TRIM_THROTTLE"] > 1:
            acceleration = loops.by_throttle(throttle, self.engine)
        return Demand(roll, climb, acceleration)

    def _forced(self, axis: str) -> float | None:
        return self._guided.value(axis, self.time, self.parameters["GUIDED_TIMEOUT"])

    def _tecs(self) -> tuple[float, float]:
        """``ModeGuided::update_target_altitude``; AP_TECS, ``_update_speed_demand``."""
        known, guided = self.parameters, self._guided
        up = self.loiter.up if guided.up is None else guided.up
        if self.time - guided.moved < STALE_ALTITUDE:
            up = self.state.up  # P/commands.cpp, set_guided_WP: until the next turn of 10 Hz
        speed = known["AIRSPEED_CRUISE"] if guided.speed is None else guided.speed
        return self.hold(up, speed, loaded=bool(known["STALL_PREVENTION"]))

    def attitude_target(self, target: AttitudeTarget) -> None:
        """See :meth:`AutopilotCore.attitude_target`: outside of GUIDED ignored without a word."""
        if self.mode == "GUIDED":
            self._guided.force(target, self.time)

    def _set_mode(self, order: Order) -> int:
        """GCS_Common.cpp, ``_set_mode_common``."""
        if not int(order.param1) & BaseMode.CUSTOM_MODE_ENABLED:
            return Result.DENIED
        name = self.mode_numbered(int(order.param2))
        if name is None:
            self.say(Severity.NOTICE, f"Mode {int(order.param2)} cannot be flown here")
            return Result.FAILED
        return self.changed(self.set_mode(name))

    def _reposition(self, order: Order) -> int:
        """P/GCS_MAVLink_Plane.cpp, ``handle_command_int_do_reposition``."""
        up = self.altitude_in_map(order.z, order.frame)
        place = (order.x, order.y, order.z)
        beyond = abs(order.x) > 90.0 or abs(order.y) > 180.0 or order.x == order.y == 0.0
        if up is None or not all(map(math.isfinite, place)) or beyond:
            return Result.DENIED
        if not int(order.param2) & REPOSITION_CHANGES_MODE and self.mode != "GUIDED":
            return Result.FAILED
        self.set_mode("GUIDED")
        east, north, _ = self.origin.position(
            math.radians(order.x), math.radians(order.y), self.origin.altitude + up
        ).tolist()
        counter = math.isfinite(order.param4) and order.param4 != 0.0
        clockwise = not counter and self.parameters["WP_LOITER_RAD"] >= 0.0
        if math.isfinite(order.param3) and order.param3 > 0.0:  # set_radius_and_direction
            self._guided.radius, clockwise = float(int(order.param3)), not counter
        radius = self._guided.radius
        if radius <= 1.0:
            radius = abs(self.parameters["WP_LOITER_RAD"])
        self.loiter = Loiter(east, north, up, radius if clockwise else -radius)
        self._guided.moved = self.time
        return Result.ACCEPTED

    def _guided_change_speed(self, order: Order) -> int:
        """``handle_command_int_guided_slew_commands``, ``ModeGuided::handle_change_airspeed``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        if int(order.param1) != SPEED_TYPE_AIRSPEED:
            return Result.DENIED
        known = self.parameters
        if not known["AIRSPEED_MIN"] <= order.param2 <= known["AIRSPEED_MAX"]:
            return Result.FAILED
        self._guided.speed = order.param2
        return Result.ACCEPTED

    def _guided_change_altitude(self, order: Order) -> int:
        """``handle_command_int_guided_slew_commands``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        up = self.altitude_in_map(order.z, order.frame)
        if up is None or order.z in (-1.0, 0.0) or not math.isfinite(up):
            return Result.DENIED
        self._guided.up = up
        return Result.ACCEPTED

    def _arm(self, order: Order) -> int:
        """P/AP_Arming.cpp: ``AP_Arming_Plane::disarm`` never by MAVLink in flight."""
        if order.param1 == 1.0:
            if self.mode == "RTL" and order.param2 != FORCED_ARMING:
                self.say(Severity.CRITICAL, "Arm: RTL mode not armable")
                return Result.FAILED
            self.armed = True
            return Result.ACCEPTED
        if order.param1 != 0.0:
            return Result.UNSUPPORTED
        if self.airframe.flying:
            return Result.FAILED
        self.armed = False
        return Result.ACCEPTED

    # P/GCS_MAVLink_Plane.cpp, handle_command_int_packet
    answers: ClassVar = {
        Cmd.DO_SET_MODE: _set_mode,
        Cmd.DO_REPOSITION: _reposition,
        Cmd.GUIDED_CHANGE_SPEED: _guided_change_speed,
        Cmd.GUIDED_CHANGE_ALTITUDE: _guided_change_altitude,
        Cmd.COMPONENT_ARM_DISARM: _arm,
        # handle_command_MAV_CMD_NAV_TAKEOFF: there is none for an aircraft without rotors.
        Cmd.NAV_TAKEOFF: lambda autopilot, order: Result.FAILED,
    }
    mode_commands: ClassVar = {Cmd.NAV_LOITER_UNLIM: "LOITER", Cmd.NAV_RETURN_TO_LAUNCH: "RTL"}
