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

from uav_tracking_mpc.autopilot.airframe import Engine, load_factor
from uav_tracking_mpc.autopilot.autopilot_core import (
    AttitudeTarget,
    AutopilotCore,
    BaseMode,
    Cmd,
    Order,
    Result,
    Severity,
    VehicleNumbers,
    WireTraits,
)
from uav_tracking_mpc.autopilot.flight_loops import TICK, Demand, Loiter, Response
from uav_tracking_mpc.dynamics.energy_hold import HoldConstants
from uav_tracking_mpc.links.mavlink.dialect import mavlink

LOITER_RADIUS = 60  # m, WP_LOITER_RAD where the aircraft is slow enough for it

# Hz, SRx_POSITION, _EXTRA1 to _EXTRA3, _EXT_STAT as ground stations set them
STREAM_RATES = {
    "GLOBAL_POSITION_INT": 4.0, "ATTITUDE": 10.0, "VFR_HUD": 10.0,
    "WIND": 4.0, "EKF_STATUS_REPORT": 4.0, "SYS_STATUS": 4.0,
    "GPS_RAW_INT": 4.0,
}  # fmt: skip


STALE_ALTITUDE = 0.1  # s for which a new guided point leaves TECS with the altitude of now
AT_ONCE = 1000.0  # m/s or m/s^2: what a rate of 0 stands for, P/GCS_MAVLink_Plane.cpp
TECS_PERIOD = 0.1  # s, of the 10 Hz at which guided altitudes are led on
ATTITUDE_BIT, THROTTLE_BIT = 0b10000000, 0b01000000  # of type_mask
AXIS_BITS = {"roll": 0b001, "pitch": 0b010, "yaw": 0b100}  # bits of type_mask


class Guided:
    """P/Plane.h, ``guided_state``; a mode change begins a new one (P/mode.cpp, ``Mode::enter``).

    Attributes:
        radius: Of the loiter in [m]; 0 for WP_LOITER_RAD.
        moved: When the guided point was last set in [s].
        altitude: Height in ``map`` [m] and rate [m/s] that 43001 asks for; None without one.
        speed: Calibrated airspeed [m/s] and acceleration [m/s^2] of 43000; None without one.
        changed_speed: Calibrated airspeed of DO_CHANGE_SPEED in [m/s]; None without one.
    """

    def __init__(self) -> None:
        self.radius = 0.0
        self.moved = -math.inf
        self.altitude: tuple[float, float] | None = None
        self.speed: tuple[float, float] | None = None
        self.changed_speed: float | None = None
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

    def altitude_now(self, up: float, point: float, now: float) -> float:
        """Height in ``map`` in [m] that TECS is told; ``ModeGuided::update_target_altitude``.

        Args:
            up: Of the aircraft in [m].
            point: Of the guided point in [m].
            now: In [s].
        """
        if now - self.moved < STALE_ALTITUDE:
            return up  # P/commands.cpp, set_guided_WP: until the next turn of 10 Hz
        if self.altitude is None:
            return point
        wanted, rate = self.altitude
        # The rate leads on from where it is now, not from the last target: it hardly climbs.
        step = (rate or AT_ONCE) * TECS_PERIOD
        return min(max(wanted, up - step), up + step)

    def speed_now(self, before: float, cruise: float) -> float:
        """Calibrated airspeed in [m/s] that is asked for; P/navigation.cpp, calc_airspeed_errors.

        Args:
            before: That of a tick ago in [m/s].
            cruise: AIRSPEED_CRUISE in [m/s].
        """
        if self.speed is None:
            return cruise if self.changed_speed is None else self.changed_speed
        wanted, rate = self.speed
        step = (rate or AT_ONCE) * TICK
        return min(max(wanted, before - step), before + step)


LEAST_LOAD_LIMIT = math.radians(25.0)  # rad, P/Attitude.cpp, apply_load_factor_roll_limits
PITCH_LAG = 0.5  # s, PTCH2SRV_TCONST
CLIMB_LAG = 1.0  # s, in which the climb rate follows that of TECS
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
    traits = WireTraits(
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
    _speed: float  # calibrated, that TECS was last told, in m/s

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
            "FS_SHORT_ACTN": 0,
            "FS_SHORT_TIMEOUT": 1.5,
            "GUIDED_TIMEOUT": 3.0,
            "LEVEL_ROLL_LIMIT": 5,
            "NAVL1_DAMPING": 0.75,
            "NAVL1_PERIOD": 17.0,
            "PTCH_LIM_MAX_DEG": 20.0,
            "PTCH_LIM_MIN_DEG": -25.0,
            "PTCH_TRIM_DEG": 0.0,
            "RLL2SRV_RMAX": round(own.roll_rate),
            "RLL2SRV_TCONST": 0.5,
            "ROLL_LIMIT_DEG": own.bank_max,
            "RTL_ALTITUDE": 100.0,
            "RTL_RADIUS": 0,
            "SCHED_LOOP_RATE": 100,
            "STALL_PREVENTION": 1,
            "STICK_MIXING": 1,
            "SYSID_ENFORCE": 0,
            "SYSID_MYGCS": 255,
            "SYSID_THISMAV": 1,
            "TECS_CLMB_MAX": own.climb_max,
            "TECS_RLL2THR": 10.0,
            "TECS_SINK_MAX": own.sink_max,
            "TECS_SINK_MIN": own.sink_idle,
            "TECS_TIME_CONST": 5.0,
            "THR_FAILSAFE": 1,
            "THR_MAX": 100,
            "TKOFF_ALT": 50,
            "TKOFF_DIST": 200,
            "TKOFF_LVL_ALT": 10,
            "TRIM_THROTTLE": 45,
            "WP_LOITER_RAD": max(LOITER_RADIUS, own.radius),
        }

    @property
    def mode_flags(self) -> int:
        """P/GCS_MAVLink_Plane.cpp, ``GCS_MAVLINK_Plane::base_mode``."""
        guided = self.mode in ("CIRCLE", "RTL", "LOITER", "TAKEOFF", "GUIDED")
        return int(BaseMode.MANUAL_INPUT_ENABLED | guided * BaseMode.GUIDED_ENABLED)

    @property
    def engine(self) -> Engine:
        """See :meth:`AutopilotCore.engine`."""
        known = self.parameters
        return Engine(
            cruise=self._configuration.controller.airspeed,
            trim=min(max(0.01 * known["TRIM_THROTTLE"], 0.05), 0.95),
            climb_max=max(known["TECS_CLMB_MAX"], 0.1),
            sink_idle=max(known["TECS_SINK_MIN"], 0.1),
            load_energy=known["TECS_RLL2THR"],
        )

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

    def mode_order(self, base_mode: int, custom_mode: int) -> Order:
        """See :meth:`AutopilotCore.mode_order`."""
        return Order(Cmd.DO_SET_MODE, float(base_mode), float(custom_mode))

    def enter(self, mode: str) -> None:
        """See :meth:`AutopilotCore.enter`; the modes' own ``_enter`` in P/mode_*.cpp."""
        known = self.parameters
        self._guided = Guided()
        self._speed = known["AIRSPEED_CRUISE"]
        radius = known["WP_LOITER_RAD"]
        self.loiter = self.loiter_here(radius)
        if mode == "RTL":  # P/mode_rtl.cpp, do_RTL: home, at RTL_ALTITUDE above it
            height = known["RTL_ALTITUDE"]
            around = known["RTL_RADIUS"] or radius
            up = self.state.up if height < 0.0 else height
            self.loiter = Loiter(0.0, 0.0, up, abs(around), around >= 0.0)
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
        up = self.loiter.up
        if self.mode == "GUIDED":
            up = self._guided.altitude_now(self.state.up, up, self.time)
        climb, acceleration = self._tecs(up)
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

    def _tecs(self, up: float) -> tuple[float, float]:
        known = self.parameters
        lowest, highest = known["AIRSPEED_MIN"], known["AIRSPEED_MAX"]
        wanted = self._guided.speed_now(self._speed, known["AIRSPEED_CRUISE"])
        self._speed = min(max(wanted, lowest), highest)
        # AP_TECS::_update_speed_demand: the least airspeed grows with the load factor
        if known["STALL_PREVENTION"]:
            lowest *= math.sqrt(load_factor(self.loops.roll_wanted))
        held = min(max(self._speed, lowest), highest) * self.density_factor
        time = max(known["TECS_TIME_CONST"], 0.5)
        constants = HoldConstants(
            height_time=time,
            climb_time=CLIMB_LAG,
            airspeed_time=time,
            climb_max=max(known["TECS_CLMB_MAX"], 0.1),
            sink_max=max(known["TECS_SINK_MAX"], 0.1),
            sink_idle=max(known["TECS_SINK_MIN"], 0.1),
        )
        return self.loops.hold(up, held, constants)

    def attitude_target(self, target: AttitudeTarget) -> None:
        """See :meth:`AutopilotCore.attitude_target`: outside of GUIDED ignored without a word."""
        if self.mode == "GUIDED":
            self._guided.force(target, self.time)

    def _set_mode(self, order: Order) -> int:
        """GCS_Common.cpp, ``_set_mode_common``."""
        if not int(order.param1) & BaseMode.CUSTOM_MODE_ENABLED:
            return Result.DENIED
        name = {number: name for name, number in self.modes.items()}.get(int(order.param2))
        if name is None:
            self.say(Severity.NOTICE, f"Mode {int(order.param2)} cannot be flown here")
            return Result.FAILED
        return self.changed(self.set_mode(name))

    def _reposition(self, order: Order) -> int:
        """P/GCS_MAVLink_Plane.cpp, ``handle_command_int_do_reposition``."""
        up = self.altitude_in_map(order.z, order.frame)
        place = (order.x, order.y, order.z)
        if up is None or not all(map(math.isfinite, place)) or abs(order.x) > 90.0:
            return Result.DENIED
        if abs(order.y) > 180.0 or order.x == order.y == 0.0:
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
        self.loiter = Loiter(east, north, up, radius, clockwise)
        self._guided.moved = self.time
        return Result.ACCEPTED

    def _guided_change_speed(self, order: Order) -> int:
        """``handle_command_int_guided_slew_commands``, ``ModeGuided::handle_change_airspeed``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        if int(order.param1) != SPEED_TYPE_AIRSPEED:
            return Result.DENIED
        if not self._may_fly(order.param2):
            return Result.FAILED
        self._guided.speed = (order.param2, abs(order.param3))
        return Result.ACCEPTED

    def _guided_change_altitude(self, order: Order) -> int:
        """``handle_command_int_guided_slew_commands``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        up = self.altitude_in_map(order.z, order.frame)
        if up is None or order.z in (-1.0, 0.0) or not math.isfinite(up):
            return Result.DENIED
        self._guided.altitude = (up, abs(order.param3))
        return Result.ACCEPTED

    def _change_speed(self, order: Order) -> int:
        """``handle_command_DO_CHANGE_SPEED``, in guided modes alone."""
        if self.mode != "GUIDED" or int(order.param1) != SPEED_TYPE_AIRSPEED:
            return Result.FAILED
        if not self._may_fly(order.param2):
            return Result.FAILED
        self._guided.changed_speed = order.param2
        return Result.ACCEPTED

    def _may_fly(self, speed: float) -> bool:
        """Whether a calibrated airspeed in [m/s] is one that may be asked for."""
        return self.parameters["AIRSPEED_MIN"] <= speed <= self.parameters["AIRSPEED_MAX"]

    def _change_altitude(self, order: Order) -> int:
        """``handle_command_int_DO_CHANGE_ALTITUDE``: of the point, which 43001 comes before."""
        up = self.altitude_in_map(order.param1, int(order.param2))
        if up is None:
            return Result.DENIED
        self.loiter = self.loiter._replace(up=up)
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
        Cmd.DO_CHANGE_SPEED: _change_speed,
        Cmd.DO_CHANGE_ALTITUDE: _change_altitude,
        Cmd.GUIDED_CHANGE_SPEED: _guided_change_speed,
        Cmd.GUIDED_CHANGE_ALTITUDE: _guided_change_altitude,
        Cmd.COMPONENT_ARM_DISARM: _arm,
        # handle_command_MAV_CMD_NAV_TAKEOFF: there is none for an aircraft without rotors.
        Cmd.NAV_TAKEOFF: lambda autopilot, order: Result.FAILED,
    }
    mode_commands: ClassVar = {Cmd.NAV_LOITER_UNLIM: "LOITER", Cmd.NAV_RETURN_TO_LAUNCH: "RTL"}
