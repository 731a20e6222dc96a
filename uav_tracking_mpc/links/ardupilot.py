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
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.atmosphere import true_over_equivalent
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, quaternion_from_euler
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import Inspection
from uav_tracking_mpc.links.mavlink.arduplane_envelope import NAMES, ArduPlaneEnvelope
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.findings import firmware, inspection, state_refusal
from uav_tracking_mpc.links.mavlink.mavlink_link import MavlinkLink
from uav_tracking_mpc.links.mavlink.requests import NOT_ANSWERED
from uav_tracking_mpc.links.mavlink.telemetry import DEGREE_SCALE, SLOW_CLIMB

GUIDED = 15
MODES = {
    0: "MANUAL", 1: "CIRCLE", 2: "STABILIZE", 3: "TRAINING", 4: "ACRO", 5: "FBWA", 6: "FBWB",
    7: "CRUISE", 8: "AUTOTUNE", 10: "AUTO", 11: "RTL", 12: "LOITER", 13: "TAKEOFF",
    14: "AVOID_ADSB", 15: "GUIDED", 16: "INITIALISING", 17: "QSTABILIZE", 18: "QHOVER",
    19: "QLOITER", 20: "QLAND", 21: "QRTL", 22: "QAUTOTUNE", 23: "QACRO", 24: "THERMAL",
    25: "LOITER_ALT_QLAND", 26: "AUTOLAND",
}  # fmt: skip
HANDED_OVER = ("CIRCLE", "AUTO", "LOITER", "GUIDED")  # modes from which command may be taken
ROLL_ALONE = 0b11111110  # type_mask: the rate of roll is not ignored, all else is
CHANGE_MODE = 1.0  # flag of DO_REPOSITION
AIRSPEED = 0.0  # type of speed of GUIDED_CHANGE_SPEED
CLOCKWISE, COUNTER_CLOCKWISE = 0.0, 1.0  # param4 of DO_REPOSITION
ALTITUDE_STEP, AIRSPEED_STEP = 0.2, 0.05  # m, m/s by which a set-point must change to be told
SETPOINT_PERIOD = 0.5  # s, at least, between altitudes and between airspeeds
SET_POINTS = {
    "altitude": mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE,
    "airspeed": mavlink.MAV_CMD_GUIDED_CHANGE_SPEED,
}
RENEWAL_PERIOD = 2.0  # s, at least, between loiters
SAME_PLACE = 2.0  # m between a place as it was told and as it comes back
PLACES = 100  # of those told; not all of them arrive
RENEWAL_SHARE, RENEWAL_DISTANCE = 0.1, 10.0  # of the radius, and m, that the centre must have moved


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
    asked_parameters = NAMES
    slow_messages = (
        mavlink.MAVLINK_MSG_ID_WIND,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_GLOBAL_INT,
    )

    def _forget(self) -> None:
        super()._forget()
        self._told: dict[str, tuple[float, float]] = {}  # value and time of each set-point
        self._loiter: tuple[FlownOrbit, float] | None = None
        self._places: deque[NDArray[np.float64]] = deque(maxlen=PLACES)  # of our loiters
        self._heeded = False  # whether it has had one of them since the commands began

    def connect(self, timeout: float) -> None:
        """See :meth:`VehicleLink.connect`."""
        super().connect(timeout)
        self.heard.telemetry.climb_frequency = SLOW_CLIMB

    def mode_name(self, custom_mode: int) -> str:
        """See :meth:`MavlinkLink.mode_name`."""
        return MODES.get(custom_mode, f"number {custom_mode}")

    def takes_commands(self, custom_mode: int) -> bool:
        """See :meth:`MavlinkLink.takes_commands`."""
        return custom_mode == GUIDED

    def _envelope(self) -> ArduPlaneEnvelope:
        altitude = self.heard.telemetry.altitude
        return ArduPlaneEnvelope(self.vehicle, true_over_equivalent(altitude or 0.0))

    def describe(self) -> Inspection:
        """See :meth:`MavlinkLink.describe`."""
        heard, envelope = self.heard, self._envelope()
        mode = self.mode_name(heard.heartbeat.custom_mode)
        refusals = [state_refusal(heard, mode, HANDED_OVER)]
        if envelope.bank_max(1.0) is None:
            refusals.append("neither ROLL_LIMIT_DEG nor LIM_ROLL_CD can be read")
        told = {"firmware": f"{self.title} {firmware(heard.version)}", "mode": mode}
        warnings = envelope.warnings(self.parameters.telemetry_rate)
        return inspection(heard, told, self.vehicle, envelope, warnings, refusals)

    def refusal(self, orbit: FlownOrbit) -> str:
        """See :meth:`MavlinkLink.refusal`: what its fence says."""
        fence = self._envelope().fence()
        return "" if fence is None else fence.refusal(orbit, self.heard.telemetry)

    def ask_for_command(self, now: float) -> None:
        """See :meth:`MavlinkLink.ask_for_command`."""
        if self.orbit is not None:
            self._reposition(self.orbit, now, CHANGE_MODE, "the mode GUIDED")

    def begin(self, now: float) -> None:
        """See :meth:`MavlinkLink.begin`: a change of mode has made it forget all set-points."""
        self._told.clear()
        self._heeded = False
        self.accompany(now)

    def accompany(self, now: float) -> None:
        """See :meth:`MavlinkLink.accompany`."""
        heard, orbit = self.heard, self.orbit
        frame = heard.telemetry.frame
        if orbit is None or frame is None:
            return
        if refusal := self.refusal(orbit):
            self.engagement.give_up(refusal)
            return
        self._tell_again()
        if self._moved(orbit, now):
            self._reposition(orbit, now, 0.0, "a loiter about the target")
        _, _, altitude = frame.place(orbit.centre)
        if self._changed("altitude", altitude, ALTITUDE_STEP, now):
            # A rate would be taken for a fraction of itself: ModeGuided::update_target_altitude.
            heard.requests.ask_there(
                now,
                mavlink.MAV_CMD_GUIDED_CHANGE_ALTITUDE,
                f"the altitude of {altitude:.1f} m above sea level",
                (0.0, 0.0, 0.0, 0.0),
                (0, 0, _no_zero(altitude)),
                quiet=True,
            )
        equivalent = orbit.airspeed / true_over_equivalent(altitude)
        if self._changed("airspeed", equivalent, AIRSPEED_STEP, now):
            heard.requests.ask_there(
                now,
                mavlink.MAV_CMD_GUIDED_CHANGE_SPEED,
                f"the airspeed of {equivalent:.1f} m/s",
                (AIRSPEED, equivalent, 0.0, 0.0),
                (0, 0, 0.0),
                quiet=True,
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
        for name, command in SET_POINTS.items():
            if result(command) == NOT_ANSWERED:
                self._told.pop(name, None)
        if result(mavlink.MAV_CMD_DO_REPOSITION) == NOT_ANSWERED:
            self._loiter = None

    def fly(self, inputs: NDArray[np.float64], measured: Measurement, now: float) -> None:
        """See :meth:`MavlinkLink.fly`."""
        if measured.airspeed is None:
            return
        limit = self._envelope().bank_max(measured.airspeed) or 0.0
        turn_rate = float(inputs[0]) - self.heard.telemetry.direction.surplus
        bank = max(-limit, min(limit, bank_from_turn_rate(turn_rate, measured.airspeed)))
        self.heard.connection.send(
            mavlink.MAVLink_set_attitude_target_message(
                self.heard.connection.boot_time, self.heard.system, 1,
                ROLL_ALONE, quaternion_from_euler(bank, 0.0, 0.0), 0.0, 0.0, 0.0, 0.0,
            )
        )  # fmt: skip

    def _changed(self, name: str, value: float, step: float, now: float) -> bool:
        """Whether a set-point is to be told; it then counts as told."""
        told, at = self._told.get(name, (math.nan, -math.inf))
        if now - at < SETPOINT_PERIOD or abs(value - told) < step:
            return False
        self._told[name] = value, now
        return True

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
