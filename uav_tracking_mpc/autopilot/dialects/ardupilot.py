"""ArduPlane, as it behaves towards a companion computer.

Files and functions named here are those of ArduPilot (ArduPilot/ardupilot, 4.6 to 4.7-dev); ``P/``
is its folder ``ArduPlane``. Pilots' sticks stay centred: modes that follow them fly wings level.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import ClassVar

from uav_tracking_mpc.autopilot.autopilot_core import FORCED_DISARM, TICK, AutopilotCore, Demand
from uav_tracking_mpc.autopilot.dialects._ardupilot_parameters import ardupilot_parameters
from uav_tracking_mpc.autopilot.loiter import Loiter
from uav_tracking_mpc.autopilot.numbers import (
    AttitudeTarget,
    BaseMode,
    Cmd,
    Order,
    Result,
    Severity,
)
from uav_tracking_mpc.autopilot.thrust import Engine
from uav_tracking_mpc.dynamics.energy_hold import HoldConstants
from uav_tracking_mpc.settings.configuration import Configuration

LEAST_LOAD_LIMIT = math.radians(25.0)  # P/Attitude.cpp, apply_load_factor_roll_limits
PITCH_LAG = 0.5  # s, PTCH2SRV_TCONST
CLIMB_LAG = 1.0  # s, in which the climb rate follows that of TECS
STALE_ALTITUDE = 0.1  # s for which a new guided point leaves TECS with the altitude of now
AT_ONCE = 1000.0  # m/s or m/s^2: what a rate of 0 stands for, P/GCS_MAVLink_Plane.cpp
TECS_PERIOD = 0.1  # s, of the 10 Hz at which guided altitudes are led on
SPEED_IS_AIRSPEED = 0.0  # SPEED_TYPE_AIRSPEED
REPOSITION_CHANGES_MODE = 1  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
CUSTOM_MODE_ENABLED = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
SPHERE = 0.011131884502145034 / math.radians(1e-7)  # m, LOCATION_SCALING_FACTOR
ATTITUDE_BIT, THROTTLE_BIT = 0b10000000, 0b01000000  # of type_mask
AXIS_BITS = {"roll": 0b001, "pitch": 0b010, "yaw": 0b100}


class ArduPlane(AutopilotCore):
    """Flies a plant as ArduPlane does.

    Its loiter radius and the limits of speed, climb and bank come from the configuration, the
    other parameters have ArduPlane's own defaults.
    """

    modes: ClassVar[Mapping[str, int]] = {  # P/mode.h, Mode::Number
        "MANUAL": 0, "CIRCLE": 1, "STABILIZE": 2, "FBWA": 5, "FBWB": 6, "CRUISE": 7, "RTL": 11,
        "LOITER": 12, "TAKEOFF": 13, "GUIDED": 15,
    }  # fmt: skip
    loiter_mode = "LOITER"
    ground_mode = "FBWA"
    off_the_ground = ("TAKEOFF",)
    # P/AP_Arming.cpp, AP_Arming_Plane::disarm: not by MAVLink while it flies.
    disarm_in_flight = Result.FAILED
    maker = 3  # MAV_AUTOPILOT_ARDUPILOTMEGA
    version = (4, 6, 0)
    # MISSION_FLOAT, PARAM_FLOAT, MISSION_INT, COMMAND_INT, SET_ATTITUDE_TARGET,
    # SET_POSITION_TARGET_GLOBAL_INT, MAVLINK2: P/GCS_MAVLink_Plane.cpp, ``capabilities``
    capabilities = 1 | 2 | 4 | 8 | 64 | 256 | 8192
    # SRx_POSITION, _EXTRA1 to _EXTRA3, _EXT_STAT as ground stations set them
    stream_rates: ClassVar[Mapping[str, float]] = {
        "GLOBAL_POSITION_INT": 4.0, "LOCAL_POSITION_NED": 4.0, "ATTITUDE": 10.0, "VFR_HUD": 10.0,
        "WIND": 4.0, "SYSTEM_TIME": 4.0, "EKF_STATUS_REPORT": 4.0, "SYS_STATUS": 4.0,
        "GPS_RAW_INT": 4.0, "NAV_CONTROLLER_OUTPUT": 4.0,
    }  # fmt: skip
    mode_messages = ("HEARTBEAT",)  # P/system.cpp, Plane::set_mode
    sync_period = 10.0
    unknown_message = Result.FAILED
    hears_all = True
    bytewise = False
    set_mode_acknowledged = 11  # MAVLINK_MSG_ID_SET_MODE

    def __init__(self, *arguments: object, **named: object) -> None:
        self._loiter: Loiter | None = None
        self._radius = 0.0  # of GUIDED, P/mode_guided.cpp, active_radius_m; 0 for WP_LOITER_RAD
        self._clockwise = True
        self._moved = -math.inf  # when the guided point was last set
        self._forced: dict[str, tuple[float, float]] = {}  # by axis, its value and since when
        self._altitude: tuple[float, float] | None = None  # guided: up in map, rate in m/s
        self._wanted_speed = 0.0  # calibrated, what TECS is told
        self._guided_speed: tuple[float, float] | None = None  # calibrated, and m/s^2
        self._changed_speed: float | None = None  # by DO_CHANGE_SPEED
        self._ground_heard: float | None = None
        super().__init__(*arguments, **named)  # type: ignore[arg-type]
        self._wanted_speed = self.parameters["AIRSPEED_CRUISE"]

    @classmethod
    def defaults(cls, configuration: Configuration, density_factor: float) -> dict[str, float]:
        """See :meth:`AutopilotCore.defaults`."""
        return ardupilot_parameters(configuration, density_factor)

    @property
    def base_mode(self) -> BaseMode:
        """P/GCS_MAVLink_Plane.cpp, ``GCS_MAVLINK_Plane::base_mode``."""
        mode = BaseMode.CUSTOM | BaseMode.MANUAL_INPUT
        if self.mode in ("CIRCLE", "RTL", "LOITER", "TAKEOFF", "GUIDED"):
            mode |= BaseMode.GUIDED
        if self.mode != "MANUAL":
            mode |= BaseMode.STABILIZE
        return mode | BaseMode.ARMED if self.armed else mode

    @property
    def engine(self) -> Engine:
        """See :meth:`AutopilotCore.engine`."""
        known = self.parameters
        return Engine(
            cruise=self._configuration.controller.airspeed,
            trim=min(max(0.01 * known["TRIM_THROTTLE"], 0.05), 0.95),
            climb_max=max(known["TECS_CLMB_MAX"], 0.1),
            sink_idle=max(known["TECS_SINK_MIN"], 0.1),
        )

    @property
    def roll_limit(self) -> float:
        """ROLL_LIMIT_DEG, and what the load factor leaves of it.

        P/ArduPlane.cpp, ``Plane::ahrs_update``; P/Attitude.cpp, ``apply_load_factor_roll_limits``.
        """
        known = self.parameters
        limit = math.radians(known["ROLL_LIMIT_DEG"]) * math.cos(self.state.pitch)
        stall = known["AIRSPEED_STALL"] or known["AIRSPEED_MIN"]
        if not known["STALL_PREVENTION"] or stall <= 0.0:
            return limit
        load = max((self.state.airspeed / self.density_factor / stall) ** 2, 1.0)
        return min(limit, max(math.acos(1.0 / load), LEAST_LOAD_LIMIT))

    @property
    def roll_response(self) -> tuple[float, float]:
        """RLL2SRV_TCONST and RLL2SRV_RMAX, 0 for none (AP_RollController::get_rate_out)."""
        rate = self.parameters["RLL2SRV_RMAX"]
        lag = max(self.parameters["RLL2SRV_TCONST"], 0.1)
        return lag, math.radians(rate) if rate > 0.0 else math.inf

    @property
    def least_interval(self) -> float:
        """0.8 of the main loop's rate at most: GCS_Common.cpp, ``cap_message_interval``."""
        return 1.0 / (0.8 * max(self.parameters["SCHED_LOOP_RATE"], 1.0))

    def local(self, latitude: float, longitude: float) -> tuple[float, float]:
        """On a sphere, AP_Common/Location.cpp ``get_distance_NE``."""
        middle = 0.5 * (latitude + self.origin.latitude)
        east = math.remainder(longitude - self.origin.longitude, 2.0 * math.pi) * math.cos(middle)
        return SPHERE * (latitude - self.origin.latitude), SPHERE * east

    def mode_order(self, base_mode: int, custom_mode: int) -> Order:
        """See :meth:`AutopilotCore.mode_order`."""
        return Order(Cmd.DO_SET_MODE, float(base_mode), float(custom_mode))

    def may_enter(self, mode: str) -> bool:
        """All modes that can be flown may be entered at any time."""
        return True

    def enter(self, mode: str) -> None:
        """P/mode.cpp, ``Mode::enter`` forgets what was forced; then the mode's ``_enter``."""
        self._forced.clear()
        self._altitude = self._guided_speed = self._changed_speed = None
        self._radius = 0.0
        radius = self.parameters["WP_LOITER_RAD"]
        self._loiter = self.loiter_here(radius)
        self._clockwise = radius >= 0.0
        if mode == "RTL":  # P/mode_rtl.cpp, do_RTL: home, at RTL_ALTITUDE above it
            height = self.parameters["RTL_ALTITUDE"]
            up = self.state.up if height < 0.0 else height
            around = self.parameters["RTL_RADIUS"] or radius
            self._loiter = Loiter(0.0, 0.0, up, abs(around), around >= 0.0)
        elif mode == "TAKEOFF":  # P/mode_takeoff.cpp: straight on, then a loiter
            distance, heading = self.parameters["TKOFF_DIST"], self.state.heading
            self._loiter = self._loiter._replace(
                east=self.state.east + distance * math.cos(heading),
                north=self.state.north + distance * math.sin(heading),
                up=max(self.parameters["TKOFF_ALT"], self.state.up),
            )

    def heard_heartbeat(self, system: int, ground_station: bool) -> None:
        """P/GCS_MAVLink_Plane.cpp: only SYSID_MYGCS counts, whatever it says it is."""
        if system == self.parameters["SYSID_MYGCS"]:
            self._ground_heard = self.time

    def watch(self) -> None:
        """The ground station's loss, P/events.cpp ``check_long_failsafe``."""
        enabled = self.parameters["FS_GCS_ENABL"] in (1, 2) and self._ground_heard is not None
        silent = (
            enabled
            and self.time - (self._ground_heard or 0.0) > (self.parameters["FS_LONG_TIMEOUT"])
        )
        if not silent:
            self.failsafe = False
            return
        if self.failsafe:
            return
        self.failsafe = True
        action = self.parameters["FS_LONG_ACTN"]
        changes = {1: "RTL", 2: "FBWA"}.get(int(action))
        if changes is None and self.mode not in ("GUIDED", "LOITER"):
            changes = "RTL"  # modes that a pilot flies always end in RTL
        if changes is not None and self.airframe.flying and self.mode != changes:
            self.set_mode(changes)
            self.say(Severity.WARNING, f"GCS Failsafe On: switched to {changes}")

    def fly(self) -> Demand:
        """P/mode_guided.cpp ``ModeGuided::update``, and the ``update`` of the other modes."""
        if self.mode in ("MANUAL", "STABILIZE", "FBWA"):
            return Demand(0.0, self.by_pitch(0.0, PITCH_LAG), self.by_throttle(self.engine.trim))
        assert self._loiter is not None
        if self.mode in ("FBWB", "CRUISE"):
            climb, acceleration = self._tecs(self._loiter.up)
            return Demand(0.0, climb, acceleration)
        climb, acceleration = self._tecs(self._target_altitude())
        if self.mode == "CIRCLE":  # P/mode_circle.cpp: a third of the roll limit
            return Demand(self.roll_limit / 3.0, climb, acceleration)
        roll = self._value("roll")
        if roll is None:
            known = self.parameters
            roll = self.bank_to(self._loiter, known["NAVL1_PERIOD"], known["NAVL1_DAMPING"])
            if self.mode == "TAKEOFF" and self.state.up < known["TKOFF_LVL_ALT"]:
                level = math.radians(known["LEVEL_ROLL_LIMIT"])
                roll = min(max(roll, -level), level)
        pitch, throttle = self._value("pitch"), self._value("throttle")
        if pitch is not None:
            lowest, highest = (
                self.parameters["PTCH_LIM_MIN_DEG"],
                self.parameters["PTCH_LIM_MAX_DEG"],
            )
            pitch = min(max(pitch, math.radians(lowest)), math.radians(highest))
            climb = self.by_pitch(pitch, PITCH_LAG)
        if throttle is not None:
            acceleration = self.by_throttle(throttle)
        return Demand(roll, climb, acceleration)

    def _value(self, axis: str) -> float | None:
        """What is forced on an axis and not older than 3 s, or GUIDED_TIMEOUT."""
        value, since = self._forced.get(axis, (0.0, -math.inf))
        return value if self.time - since < self.parameters["GUIDED_TIMEOUT"] else None

    def _target_altitude(self) -> float:
        """Height in ``map`` in [m] that TECS is told: P/mode_guided.cpp, update_target_altitude."""
        assert self._loiter is not None
        if self.mode == "GUIDED" and self.time - self._moved < STALE_ALTITUDE:
            return self.state.up  # P/commands.cpp, set_guided_WP: until the next turn of 10 Hz
        if self._altitude is None:
            return self._loiter.up
        up, rate = self._altitude
        # The rate leads on from where it is now, not from the last target: it hardly climbs.
        step = rate * TECS_PERIOD
        return min(max(up, self.state.up - step), self.state.up + step)

    def _tecs(self, up: float) -> tuple[float, float]:
        known = self.parameters
        wanted = known["AIRSPEED_CRUISE"]
        if self._changed_speed is not None:
            wanted = self._changed_speed
        if self.mode == "GUIDED" and self._guided_speed is not None:
            # P/navigation.cpp, calc_airspeed_errors: a slew from the last demand
            target, rate = self._guided_speed
            step = rate * TICK
            wanted = min(max(target, self._wanted_speed - step), self._wanted_speed + step)
        # AP_TECS::_update_speed_demand: the least airspeed grows with the load factor
        least = known["AIRSPEED_MIN"]
        if known["STALL_PREVENTION"]:
            least /= math.sqrt(math.cos(min(abs(self.roll_wanted), math.radians(80.0))))
        self._wanted_speed = min(max(wanted, known["AIRSPEED_MIN"]), known["AIRSPEED_MAX"])
        held = min(max(self._wanted_speed, least), known["AIRSPEED_MAX"])
        constants = HoldConstants(
            height_time=max(known["TECS_TIME_CONST"], 0.5),
            climb_time=CLIMB_LAG,
            airspeed_time=max(known["TECS_TIME_CONST"], 0.5),
            climb_max=max(known["TECS_CLMB_MAX"], 0.1),
            sink_max=max(known["TECS_SINK_MAX"], 0.1),
            sink_idle=max(known["TECS_SINK_MIN"], 0.1),
        )
        return self.hold(up, held, constants)

    def attitude_target(self, target: AttitudeTarget) -> None:
        """P/GCS_MAVLink_Plane.cpp, ``handle_set_attitude_target``.

        Outside of GUIDED it is ignored without a word. Where the attitude is not left out, all
        three axes are forced, whatever the bits of the rates say.
        """
        if self.mode != "GUIDED":
            return
        taken = ~target.mask & 0xFF
        values = {"roll": target.roll, "pitch": target.pitch, "yaw": 0.0}
        for axis, bit in AXIS_BITS.items():
            if taken & (ATTITUDE_BIT | bit):
                self._forced[axis] = (values[axis], self.time)
        if taken & THROTTLE_BIT and self.parameters["TRIM_THROTTLE"] > 1:
            self._forced["throttle"] = (target.thrust, self.time)

    def command(self, order: Order) -> Result:
        """P/GCS_MAVLink_Plane.cpp, ``handle_command_int_packet``."""
        answer = _ANSWERS.get(order.command)
        return Result.UNSUPPORTED if answer is None else answer(self, order)

    def _set_mode(self, order: Order) -> Result:
        """GCS_Common.cpp, ``_set_mode_common``."""
        if not int(order.param1) & CUSTOM_MODE_ENABLED:
            return Result.DENIED
        name = {number: name for name, number in self.modes.items()}.get(int(order.param2))
        if name is None:
            self.say(Severity.NOTICE, f"Mode {int(order.param2)} cannot be flown here")
            return Result.FAILED
        return Result.ACCEPTED if self.set_mode(name) else Result.FAILED

    def _reposition(self, order: Order) -> Result:
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
            self._radius, clockwise = float(int(order.param3)), not counter
        radius = self._radius if self._radius > 1.0 else abs(self.parameters["WP_LOITER_RAD"])
        self._loiter = Loiter(east, north, up, radius, clockwise)
        self._moved = self.time
        return Result.ACCEPTED

    def _guided_change_speed(self, order: Order) -> Result:
        """``handle_command_int_guided_slew_commands``, ``ModeGuided::handle_change_airspeed``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        if int(order.param1) != SPEED_IS_AIRSPEED:
            return Result.DENIED
        known = self.parameters
        if not known["AIRSPEED_MIN"] <= order.param2 <= known["AIRSPEED_MAX"]:
            return Result.FAILED
        self._guided_speed = (order.param2, abs(order.param3) or AT_ONCE)
        return Result.ACCEPTED

    def _guided_change_altitude(self, order: Order) -> Result:
        """``handle_command_int_guided_slew_commands``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        up = self.altitude_in_map(order.z, order.frame)
        if up is None or order.z in (-1.0, 0.0) or not math.isfinite(up):
            return Result.DENIED
        self._altitude = (up, abs(order.param3) or AT_ONCE)
        return Result.ACCEPTED

    def _change_speed(self, order: Order) -> Result:
        """``handle_command_DO_CHANGE_SPEED``, in guided modes alone."""
        known = self.parameters
        if self.mode != "GUIDED" or int(order.param1) != SPEED_IS_AIRSPEED:
            return Result.FAILED
        if not known["AIRSPEED_MIN"] <= order.param2 <= known["AIRSPEED_MAX"]:
            return Result.FAILED
        self._changed_speed = order.param2
        return Result.ACCEPTED

    def _change_altitude(self, order: Order) -> Result:
        """``handle_command_int_DO_CHANGE_ALTITUDE``: of the point, which 43001 comes before."""
        up = self.altitude_in_map(order.param1, int(order.param2))
        if up is None or self._loiter is None:
            return Result.DENIED
        self._loiter = self._loiter._replace(up=up)
        return Result.ACCEPTED

    def _arm(self, order: Order) -> Result:
        if order.param1 == 1.0 and self.mode == "RTL" and order.param2 != FORCED_DISARM:
            self.say(Severity.CRITICAL, "Arm: RTL mode not armable")
            return Result.FAILED
        return self.arm(order)


def _to(mode: str) -> Callable[[ArduPlane, Order], Result]:
    def changed(autopilot: ArduPlane, order: Order) -> Result:
        return Result.ACCEPTED if autopilot.set_mode(mode) else Result.FAILED

    return changed


_ANSWERS: dict[int, Callable[[ArduPlane, Order], Result]] = {
    Cmd.DO_SET_MODE: ArduPlane._set_mode,
    Cmd.DO_REPOSITION: ArduPlane._reposition,
    Cmd.DO_CHANGE_SPEED: ArduPlane._change_speed,
    Cmd.DO_CHANGE_ALTITUDE: ArduPlane._change_altitude,
    Cmd.GUIDED_CHANGE_SPEED: ArduPlane._guided_change_speed,
    Cmd.GUIDED_CHANGE_ALTITUDE: ArduPlane._guided_change_altitude,
    Cmd.COMPONENT_ARM_DISARM: ArduPlane._arm,
    Cmd.NAV_LOITER_UNLIM: _to("LOITER"),
    Cmd.NAV_RETURN_TO_LAUNCH: _to("RTL"),
    # handle_command_MAV_CMD_NAV_TAKEOFF: there is none for an aircraft without rotors.
    Cmd.NAV_TAKEOFF: lambda autopilot, order: Result.FAILED,
}
