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
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import ClassVar

from uav_tracking_mpc.autopilot.autopilot_core import AutopilotCore
from uav_tracking_mpc.autopilot.dialects._ardupilot_guided import Guided
from uav_tracking_mpc.autopilot.dialects._ardupilot_parameters import (
    ARDUPILOT_TRAITS,
    ardupilot_parameters,
)
from uav_tracking_mpc.autopilot.flight_loops import Demand, Response
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
STEEPEST = math.radians(80.0)  # up to which the load factor of a bank is told
PITCH_LAG = 0.5  # s, PTCH2SRV_TCONST
CLIMB_LAG = 1.0  # s, in which the climb rate follows that of TECS
SPEED_TYPE_AIRSPEED = 0
REPOSITION_CHANGES_MODE = 1  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
CUSTOM_MODE_ENABLED = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
FORCED_ARMING = 2989.0  # P/AP_Arming.cpp: magic value of MAV_CMD_COMPONENT_ARM_DISARM
SPHERE = 0.011131884502145034 / math.radians(1e-7)  # m, LOCATION_SCALING_FACTOR


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
    traits = ARDUPILOT_TRAITS
    _guided: Guided
    _speed: float  # calibrated, that TECS was last told, in m/s

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

    def local(self, latitude: float, longitude: float) -> tuple[float, float]:
        """See :meth:`AutopilotCore.local`; on a sphere, Location.cpp ``get_distance_NE``."""
        middle = 0.5 * (latitude + self.origin.latitude)
        east = math.remainder(longitude - self.origin.longitude, 2.0 * math.pi) * math.cos(middle)
        return SPHERE * (latitude - self.origin.latitude), SPHERE * east

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
            trim = loops.by_throttle(self.engine.trim, self.engine)
            return Demand(0.0, loops.by_pitch(self._level_pitch, PITCH_LAG), trim)
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

    @property
    def _level_pitch(self) -> float:
        """Pitch in [rad] of a pilot who keeps the height with the stick."""
        return self.airframe.incidence(self.state.airspeed, self.state.roll)

    def _forced(self, axis: str) -> float | None:
        return self._guided.value(axis, self.time, self.parameters["GUIDED_TIMEOUT"])

    def _tecs(self, up: float) -> tuple[float, float]:
        known = self.parameters
        lowest, highest = known["AIRSPEED_MIN"], known["AIRSPEED_MAX"]
        wanted = self._guided.speed_now(self._speed, known["AIRSPEED_CRUISE"])
        self._speed = min(max(wanted, lowest), highest)
        # AP_TECS::_update_speed_demand: the least airspeed grows with the load factor
        if known["STALL_PREVENTION"]:
            lowest /= math.sqrt(math.cos(min(abs(self.loops.roll_wanted), STEEPEST)))
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

    def command(self, order: Order) -> Result:
        """See :meth:`AutopilotCore.command`; P/GCS_MAVLink_Plane.cpp, handle_command_int_packet."""
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
            self._guided.radius, clockwise = float(int(order.param3)), not counter
        radius = self._guided.radius
        if radius <= 1.0:
            radius = abs(self.parameters["WP_LOITER_RAD"])
        self.loiter = Loiter(east, north, up, radius, clockwise)
        self._guided.moved = self.time
        return Result.ACCEPTED

    def _guided_change_speed(self, order: Order) -> Result:
        """``handle_command_int_guided_slew_commands``, ``ModeGuided::handle_change_airspeed``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        if int(order.param1) != SPEED_TYPE_AIRSPEED:
            return Result.DENIED
        if not self._may_fly(order.param2):
            return Result.FAILED
        self._guided.speed = (order.param2, abs(order.param3))
        return Result.ACCEPTED

    def _guided_change_altitude(self, order: Order) -> Result:
        """``handle_command_int_guided_slew_commands``."""
        if self.mode != "GUIDED":
            return Result.FAILED
        up = self.altitude_in_map(order.z, order.frame)
        if up is None or order.z in (-1.0, 0.0) or not math.isfinite(up):
            return Result.DENIED
        self._guided.altitude = (up, abs(order.param3))
        return Result.ACCEPTED

    def _change_speed(self, order: Order) -> Result:
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

    def _change_altitude(self, order: Order) -> Result:
        """``handle_command_int_DO_CHANGE_ALTITUDE``: of the point, which 43001 comes before."""
        up = self.altitude_in_map(order.param1, int(order.param2))
        if up is None:
            return Result.DENIED
        self.loiter = self.loiter._replace(up=up)
        return Result.ACCEPTED

    def _arm(self, order: Order) -> Result:
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
