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

"""ArduPlane in GUIDED: it is told the bank, and holds altitude and airspeed itself.

============================  ===============================================================
SET_ATTITUDE_TARGET           bank, from the turn rate; type_mask says that roll alone counts
GUIDED_CHANGE_ALTITUDE        altitude of the orbit, which its energy control (TECS) holds
GUIDED_CHANGE_SPEED           airspeed of the orbit, likewise
DO_REPOSITION                 enters GUIDED; loiter about the target, should we fall silent
============================  ===============================================================

Read in ArduPilot's sources: ``GCS_MAVLINK_Plane::handle_set_attitude_target`` takes single axes
only with ATTITUDE_IGNORE set, and keeps a forced roll for 3 s; after that ``ModeGuided::update``
flies the loiter of the last DO_REPOSITION (ArduPlane/GCS_MAVLink_Plane.cpp, mode_guided.cpp).
Altitude and airspeed, once told, hold in that loiter too, until the mode changes
(``Mode::enter``). A DO_REPOSITION lets TECS hold the present altitude for one step of 0.1 s
(``Plane::set_guided_WP``), hence it is not renewed more often than needed.

What ArduPlane's parameters allow is the envelope of the controller, and what speaks against a
flight. Names are looked up by presence, since they changed with versions (LIM_ROLL_CD and
ROLL_LIMIT_DEG).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import true_over_equivalent
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, quaternion_from_euler
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.findings import (
    BANK_KEPT,
    RATE_SHARE,
    HomeFence,
    VehicleEnvelope,
    applying,
    climb_angle,
    known,
)
from uav_tracking_mpc.links.mavlink.mavlink_link import MavlinkLink
from uav_tracking_mpc.links.mavlink.requests import NOT_ANSWERED
from uav_tracking_mpc.links.mavlink.telemetry import DEGREE_SCALE

NAMES = (
    "ROLL_LIMIT_DEG", "LIM_ROLL_CD", "AIRSPEED_MIN", "ARSPD_FBW_MIN", "AIRSPEED_MAX",
    "ARSPD_FBW_MAX", "AIRSPEED_CRUISE", "TRIM_ARSPD_CM", "AIRSPEED_STALL", "STALL_PREVENTION",
    "WP_LOITER_RAD", "TECS_CLMB_MAX", "TECS_SINK_MIN", "TECS_SINK_MAX", "TECS_TIME_CONST",
    "RLL2SRV_TCONST", "RLL2SRV_RMAX", "ARSPD_USE", "SCHED_LOOP_RATE", "GUIDED_TIMEOUT",
    "FS_LONG_ACTN", "FS_GCS_ENABL", "FENCE_ENABLE", "FENCE_AUTOENABLE",
    "FENCE_ACTION", "FENCE_TYPE", "FENCE_ALT_MAX", "FENCE_ALT_MIN", "FENCE_RADIUS",
    "STICK_MIXING", "ALT_OFFSET",
)  # fmt: skip
# -, new name of each, and how much of its unit the old one had
OLD_NAMES = {
    "LIM_ROLL_CD": ("ROLL_LIMIT_DEG", 1e-2), "TRIM_ARSPD_CM": ("AIRSPEED_CRUISE", 1e-2),
    "ARSPD_FBW_MIN": ("AIRSPEED_MIN", 1.0), "ARSPD_FBW_MAX": ("AIRSPEED_MAX", 1.0),
}  # fmt: skip
FENCE_ALTITUDE_MAX, FENCE_CIRCLE, FENCE_ALTITUDE_MIN = 1, 2, 8  # bits of FENCE_TYPE
FENCE_RTL = (1.0, 8.0)  # codes of actions that take GUIDED away
SHARE_OF_LOOP = 0.8  # -, of the main loop's rate, that telemetry can have


class ArduPlaneEnvelope(VehicleEnvelope):
    """Limits that ArduPlane keeps.

    Args:
        vehicle: Its parameters by name, in their own units [SI or deg].
        true_over_equivalent: True over equivalent airspeed where it flies [-].
    """

    names, cruise_name = NAMES, "AIRSPEED_CRUISE"

    def __init__(self, vehicle: Mapping[str, float], true_over_equivalent: float) -> None:
        renamed = {
            new: vehicle[old] * share for old, (new, share) in OLD_NAMES.items() if old in vehicle
        }
        super().__init__({**renamed, **vehicle}, true_over_equivalent)

    def values(self, airspeed: float) -> dict[str, Any]:
        """See :meth:`VehicleEnvelope.values`."""
        bank = self.bank_max(airspeed)
        least, most, lag, rate = self.told(
            "AIRSPEED_MIN", "AIRSPEED_MAX", "RLL2SRV_TCONST", "RLL2SRV_RMAX"
        )
        climb, sink, idle, constant = self.told(
            "TECS_CLMB_MAX", "TECS_SINK_MAX", "TECS_SINK_MIN", "TECS_TIME_CONST"
        )
        return known(
            {
                "bank_max": math.nan if bank is None else bank - BANK_KEPT,
                "airspeed_min": least * self.ratio,
                "airspeed_max": most * self.ratio,
                # AP_RollController asks for a roll rate of error / TCONST; no other is commanded.
                "rate_lag": (lag, lag, lag),
                "roll_rate_max": RATE_SHARE * math.radians(rate) if rate > 0.0 else math.nan,
                "path_angle_max": climb_angle(climb, airspeed),
                "path_angle_min": climb_angle(-sink, airspeed),
                "hold_climb_max": climb,
                "hold_sink_max": sink,
                "hold_sink_idle": idle,
                "hold_time": (constant, 1.0, constant),
            }
        )

    def bank_max(self, airspeed: float) -> float | None:
        """See :meth:`VehicleEnvelope.bank_max`: what the autopilot flies.

        With STALL_PREVENTION the load factor is limited by the airspeed over the stall speed
        (ArduPlane/Attitude.cpp, ``Plane::apply_load_factor_roll_limits``).

        Args:
            airspeed: True, in [m/s].
        """
        limit, slowest = self.told("ROLL_LIMIT_DEG", "AIRSPEED_MIN")
        stall = self.vehicle.get("AIRSPEED_STALL") or slowest
        prevented = self.vehicle.get("STALL_PREVENTION", 1.0)
        return self.turning(limit, airspeed, stall if prevented else math.nan)

    @property
    def _fenced(self) -> bool:
        """Whether it has a fence, or enables one by itself in the air (``AC_Fence``)."""
        return any(self.vehicle.get(f"FENCE_{name}") for name in ("ENABLE", "AUTOENABLE"))

    def fence(self) -> HomeFence | None:
        """See :meth:`VehicleEnvelope.fence`."""
        vehicle = self.vehicle
        if not self._fenced:
            return None
        kinds, free = int(vehicle.get("FENCE_TYPE", 0.0)), math.inf
        return HomeFence(
            vehicle.get("FENCE_ALT_MIN", -free) if kinds & FENCE_ALTITUDE_MIN else -free,
            vehicle.get("FENCE_ALT_MAX", free) if kinds & FENCE_ALTITUDE_MAX else free,
            vehicle.get("FENCE_RADIUS", free) if kinds & FENCE_CIRCLE else free,
        ).kept

    def refusals(self) -> list[str]:
        """See :meth:`VehicleEnvelope.refusals`."""
        words = "neither ROLL_LIMIT_DEG nor LIM_ROLL_CD can be read"
        return applying((self.bank_max(1.0) is None, words))

    def warnings(self, telemetry_rate: float) -> list[str]:
        """See :meth:`VehicleEnvelope.warnings`."""
        loop, timeout = self.told("SCHED_LOOP_RATE", "GUIDED_TIMEOUT")
        vehicle, action = self.vehicle, self.vehicle.get("FENCE_ACTION", 1.0)
        fenced = self._fenced
        return applying(
            (
                SHARE_OF_LOOP * loop < telemetry_rate,
                f"SCHED_LOOP_RATE is {loop:g} Hz: telemetry comes at {SHARE_OF_LOOP * loop:g} Hz, "
                f"not at {telemetry_rate:g}",
            ),
            (
                timeout <= 0.0 or timeout > 5.0,
                f"GUIDED_TIMEOUT is {timeout:g} s: it decides how long the last bank is held when "
                "the companion falls silent, must be from 0 to 5 s",
            ),
            (
                fenced and action not in FENCE_RTL,
                f"FENCE_ACTION is {action:g}: a breach does not take GUIDED away, 1 (RTL) would",
            ),
            (not fenced, "FENCE_ENABLE is 0: the autopilot has no fence of its own"),
            (
                bool(vehicle.get("STICK_MIXING")),
                "STICK_MIXING is on: the pilot's sticks add to our bank in GUIDED",
            ),
        )


GUIDED = 15  # code of the mode
MODES = {
    0: "MANUAL", 1: "CIRCLE", 2: "STABILIZE", 3: "TRAINING", 4: "ACRO", 5: "FBWA", 6: "FBWB",
    7: "CRUISE", 8: "AUTOTUNE", 10: "AUTO", 11: "RTL", 12: "LOITER", 13: "TAKEOFF",
    14: "AVOID_ADSB", 15: "GUIDED", 16: "INITIALISING", 17: "QSTABILIZE", 18: "QHOVER",
    19: "QLOITER", 20: "QLAND", 21: "QRTL", 22: "QAUTOTUNE", 23: "QACRO", 24: "THERMAL",
    25: "LOITER_ALT_QLAND", 26: "AUTOLAND",
}  # fmt: skip
ROLL_ALONE = 0b11111110  # type_mask; the rate of roll is not ignored, all else is
CHANGE_MODE = 1.0  # flag of DO_REPOSITION
AIRSPEED = 0.0  # code of the airspeed in GUIDED_CHANGE_SPEED
CLOCKWISE, COUNTER_CLOCKWISE = 0.0, 1.0  # codes: param4 of DO_REPOSITION
ALTITUDE_STEP, AIRSPEED_STEP = 0.2, 0.05  # m, m/s by which a set-point must change to be sent
SETPOINT_PERIOD = 0.5  # s, at least, between altitudes and between airspeeds
STEPS = {
    mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE: ALTITUDE_STEP,
    mavlink.MAV_CMD_GUIDED_CHANGE_SPEED: AIRSPEED_STEP,
}
RENEWAL_PERIOD = 2.0  # s, at least, between loiters
SAME_PLACE = 2.0  # m between a place as it was told and as it comes back
PLACES = 100  # of those that were sent; not all of them arrive
RENEWAL_SHARE, RENEWAL_DISTANCE = 0.1, 10.0  # -, m that the centre must have moved


class ArduPilotLink(MavlinkLink):
    """ArduPlane, which is asked for its mode GUIDED."""

    name = "ardupilot"
    title = "ArduPlane"
    when_silent = (
        "holds its bank for 3 s, then loiters about the last known place of the target at the "
        "orbit's altitude and airspeed"
    )
    holds = True
    autopilot = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    handed_over = ("CIRCLE", "AUTO", "LOITER", "GUIDED")
    limits = ArduPlaneEnvelope
    slow_messages = (
        mavlink.MAVLINK_MSG_ID_WIND,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT,
    )

    def _forget(self) -> None:
        super()._forget()
        self._told: dict[int, tuple[float, float]] = {}  # value and time of each set-point
        self._loiter: tuple[FlownOrbit, float] | None = None
        self._places: deque[NDArray[np.float64]] = deque(maxlen=PLACES)  # of our loiters
        self._heeded = False  # whether it has had one of them since the commands began

    def mode_name(self, custom_mode: int) -> str:
        """See :meth:`MavlinkLink.mode_name`."""
        return MODES.get(custom_mode, f"number {custom_mode}")

    def takes_commands(self, custom_mode: int) -> bool:
        """See :meth:`MavlinkLink.takes_commands`."""
        return custom_mode == GUIDED

    def ask_for_command(self, now: float) -> None:
        """See :meth:`MavlinkLink.ask_for_command`."""
        if self.orbit is not None:
            self._reposition(self.orbit, now, CHANGE_MODE, "the mode GUIDED")

    def begin(self, now: float) -> None:
        """See :meth:`MavlinkLink.begin`: a change of mode has made it forget all it was told."""
        self._told.clear()
        self._loiter, self._heeded = None, False
        self.accompany(now)

    def accompany(self, now: float) -> None:
        """See :meth:`MavlinkLink.accompany`."""
        orbit, frame = self.orbit, self.heard.telemetry.frame
        if orbit is None or frame is None:
            return
        if refusal := self.refusal(orbit):
            self.engagement.give_up(refusal)
            return
        self._tell_again()
        if self._moved(orbit, now):
            self._reposition(orbit, now, 0.0, "a loiter about the target")
        _, _, altitude = frame.place(orbit.centre)
        slowest, fastest = self.envelope().told("AIRSPEED_MIN", "AIRSPEED_MAX")
        # Another one is refused; an orbit far above has its own ratio to the true airspeed.
        equivalent = min(max(orbit.airspeed / true_over_equivalent(altitude), slowest), fastest)
        self._set(
            mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE,
            altitude,
            f"the altitude of {altitude:.1f} m above sea level",
            # A rate would be taken for a fraction of itself: ModeGuided::update_target_altitude.
            (0.0, 0.0, 0.0, 0.0),
            _no_zero(altitude),
            now,
        )
        self._set(
            mavlink.MAV_CMD_GUIDED_CHANGE_SPEED,
            equivalent,
            f"the airspeed of {equivalent:.1f} m/s",
            (AIRSPEED, equivalent, 0.0, 0.0),
            0.0,
            now,
        )

    def _see(self, message: Any, arrival: float) -> None:
        """See :class:`MavlinkLink`: a place to fly to that is not ours ends our commands."""
        super()._see(message, arrival)
        frame = self.heard.telemetry.frame
        kind = message.get_type()
        if kind != "POSITION_TARGET_GLOBAL_INT" or frame is None or not self.engagement.commanding:
            return
        place = frame.position(
            message.lat_int * DEGREE_SCALE, message.lon_int * DEGREE_SCALE, message.alt
        )
        if any(np.linalg.norm(place[:2] - ours) < SAME_PLACE for ours in self._places):
            self._heeded = True
        elif self._heeded:
            self.engagement.give_up("a ground station sent the aircraft to another place")

    def _tell_again(self) -> None:
        """What was not answered while the link was dead counts as never told."""
        result = self.heard.requests.result
        for command in STEPS:
            if result(command) == NOT_ANSWERED:
                self._told.pop(command, None)
        if result(mavlink.MAV_CMD_DO_REPOSITION) == NOT_ANSWERED:
            self._loiter = None

    def fly(self, inputs: NDArray[np.float64], measured: Measurement, now: float) -> None:
        """See :meth:`MavlinkLink.fly`."""
        airspeed = self.heard.telemetry.flown_airspeed
        if airspeed is None:
            return
        limit = self.envelope().bank_max(airspeed) or 0.0
        turn_rate = float(inputs[0]) - self.heard.telemetry.surplus
        bank = max(-limit, min(limit, bank_from_turn_rate(turn_rate, airspeed)))
        self.heard.connection.send(
            mavlink.MAVLink_set_attitude_target_message(
                self.heard.connection.boot_time, self.heard.system, 1,
                ROLL_ALONE, quaternion_from_euler(bank, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0,
            )
        )  # fmt: skip

    def _set(
        self,
        command: int,
        value: float,
        words: str,
        parameters: tuple[float, float, float, float],
        altitude: float,
        now: float,
    ) -> None:
        """Tell a set-point that has changed, unless it was told just before."""
        told, at = self._told.get(command, (math.nan, -math.inf))
        if now - at >= SETPOINT_PERIOD and not abs(value - told) < STEPS[command]:
            self._told[command] = value, now
            place = (0, 0, altitude)
            self.heard.requests.ask_there(now, command, words, parameters, place, quiet=True)

    def _moved(self, orbit: FlownOrbit, now: float) -> bool:
        """Whether the loiter is to be renewed."""
        if self._loiter is None:
            return True
        loiter, at = self._loiter
        moved = float(np.linalg.norm(orbit.centre[:2] - loiter.centre[:2]))
        reach = max(RENEWAL_DISTANCE, RENEWAL_SHARE * abs(orbit.radius))
        turned = orbit.radius * loiter.radius < 0.0
        grown = abs(orbit.radius - loiter.radius) > reach
        return now - at >= RENEWAL_PERIOD and (moved > reach or turned or grown)

    def _reposition(self, orbit: FlownOrbit, now: float, flag: float, words: str) -> None:
        """Loiter about the orbit's centre, as soon as nothing else is commanded."""
        heard = self.heard
        frame = heard.telemetry.frame
        if frame is None:
            return
        latitude, longitude, altitude = frame.place(orbit.centre)
        direction = COUNTER_CLOCKWISE if orbit.radius > 0.0 else CLOCKWISE
        heard.requests.ask_there(
            now,
            mavlink.MAV_CMD_DO_REPOSITION,
            words,
            (-1.0, flag, max(abs(orbit.radius), 1.0), direction),
            (
                round(math.degrees(latitude) * 1e7),
                round(math.degrees(longitude) * 1e7),
                _no_zero(altitude),
            ),
            quiet=flag == 0.0,
        )
        self._loiter = orbit, now
        self._places.appendleft(orbit.centre[:2])


def _no_zero(altitude: float) -> float:
    """An altitude in [m] that ArduPlane takes: it refuses 0 and -1 m."""
    return altitude + 0.01 if altitude in (0.0, -1.0) else altitude
