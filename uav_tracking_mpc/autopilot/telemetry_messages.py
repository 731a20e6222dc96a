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

"""Telemetry: messages of the dialect from the state of an autopilot, by name, each at its rate.

Units and frames are those of the MAVLink common message set.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from numpy.typing import ArrayLike

from uav_tracking_mpc.autopilot.airframe import FlightState
from uav_tracking_mpc.autopilot.autopilot_core import AutopilotCore
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.links.mavlink.dialect import CURRENT_MODE, mavlink

ROUNDING = 1e-6  # s, rounding of times


class MessageRates:
    """Intervals of messages by name.

    Args:
        rates: How often each is sent where nobody asks otherwise, in [Hz].
    """

    def __init__(self, rates: Mapping[str, float]) -> None:
        self._usual = {name: 1.0 / rate for name, rate in rates.items()}
        self._intervals = dict(self._usual)
        self._due: dict[str, float] = dict.fromkeys(self._intervals, 0.0)

    def ask(self, name: str, interval: float) -> None:
        """MAV_CMD_SET_MESSAGE_INTERVAL.

        Args:
            name: Of the message.
            interval: In [s]; 0 for the usual one, negative for never.
        """
        if interval == 0.0:
            interval = self._usual.get(name, -1.0)
        if interval < 0.0:
            self._intervals.pop(name, None)
            return
        self._intervals[name] = interval
        self._due[name] = 0.0

    def due(self, now: float) -> list[str]:
        """Names of the messages that are due, which then count as sent.

        Args:
            now: Time since the start in [s].
        """
        found = []
        for name, interval in self._intervals.items():
            if now + ROUNDING < self._due[name]:
                continue
            found.append(name)
            late = now - self._due[name]
            # On a grid of the interval, so that the mean rate is what was asked for.
            self._due[name] = now + interval - (late if late < interval else 0.0)
        return found


Builder = Callable[[AutopilotCore, FlightState], Any]  # from the state as its sensors tell it

ONLY_PLACE = 0xFFF8  # type_mask
# bits of gyro, accelerometer, magnetometer, absolute and differential pressure, GPS, AHRS, logging.
SENSORS = 0b11111 | 1 << 5 | 1 << 21
GOOD_FLAGS = 0b111111  # bits: attitude, velocities, horizontal positions, vertical position
GOOD_RATIO = 0.1  # -, of an innovation to its gate
GPS_FIX_3D, SATELLITES = 3, 12  # code of the fix, and how many
GPS_ACCURACY = {"h_acc": 900, "v_acc": 1500, "vel_acc": 200}  # mm, mm, mm/s
UNKNOWN = 65535  # code of an unsigned field of 16 bits
IN_AIR, ON_GROUND = 2, 1  # codes of MAV_LANDED_STATE


def telemetry(core: AutopilotCore, name: str) -> Any:
    """A message of an autopilot as it is now.

    Args:
        core: The autopilot.
        name: Of the message.
    """
    return BUILDERS[name](core, core.airframe.measured)


def milliseconds(core: AutopilotCore, state: FlightState) -> int:
    """Time since boot of a state in [ms], as it fits 32 bits.

    Args:
        core: Of the vehicle.
        state: Of the vehicle.
    """
    return round((state.time + core.clock_offset) * 1e3) % 2**32


def microseconds(core: AutopilotCore, state: FlightState) -> int:
    """Time since boot of a state in [us].

    Args:
        core: Of the vehicle.
        state: Of the vehicle.
    """
    return max(round((state.time + core.clock_offset) * 1e6), 0)


def on_the_wire(frame: LocalFrame, point: ArrayLike) -> tuple[int, int, int]:
    """Latitude and longitude in [1e-7 deg] and altitude in [mm] of a place.

    Args:
        frame: Axes of ``map``.
        point: In ``map``, shape (3,), in [m].
    """
    latitude, longitude, altitude = frame.place(point)
    degrees = math.degrees(latitude), math.degrees(longitude)
    return round(degrees[0] * 1e7), round(degrees[1] * 1e7), round(altitude * 1e3)


def position_message(
    frame: LocalFrame, time: int, position: ArrayLike, velocity: Sequence[float], yaw: float
) -> Any:
    """GLOBAL_POSITION_INT of a vehicle.

    Args:
        frame: Axes of ``map``.
        time: Since its boot in [ms].
        position: In ``map``, shape (3,), in [m].
        velocity: East, north and up in [m/s].
        yaw: Of its nose, clockwise from North, in [rad].
    """
    latitude, longitude, height = on_the_wire(frame, position)
    east, north, up = (round(100.0 * speed) for speed in velocity)
    heading = round(math.degrees(yaw) % 360.0 * 100.0) % 36000
    return mavlink.MAVLink_global_position_int_message(
        time, latitude, longitude, height, height - round(frame.altitude * 1e3), north, east, -up,
        heading,
    )  # fmt: skip


NOTHING = (0.0, 0.0, 0.0)  # -, of a vector on the wire
BUILDERS: dict[str, Builder] = {
    "HEARTBEAT": lambda core, state: mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_FIXED_WING,
        core.traits.maker,
        core.base_mode,
        core.custom_mode,
        core.system_state,
        3,
    ),
    "ATTITUDE": lambda core, state: mavlink.MAVLink_attitude_message(
        milliseconds(core, state),
        state.roll,
        state.pitch,
        state.yaw,
        state.roll_rate,
        state.pitch_rate,
        state.yaw_rate,
    ),
    "AUTOPILOT_VERSION": lambda core, state: mavlink.MAVLink_autopilot_version_message(
        core.traits.capabilities,
        int.from_bytes(
            bytes([*core.traits.version, mavlink.FIRMWARE_VERSION_TYPE_OFFICIAL]), "big"
        ),
        *(0, 0, 0),
        list(b"simulate"),
        *([0] * 8, [0] * 8),
        *(0, 0, 0),
    ),
    # streams/CURRENT_MODE.hpp: the mode, and that which the pilot wants
    "CURRENT_MODE": lambda core, state: mavlink.mavlink_map[CURRENT_MODE](
        0, core.custom_mode, core.intended_custom_mode
    ),
    "EKF_STATUS_REPORT": lambda core, state: mavlink.MAVLink_ekf_status_report_message(
        GOOD_FLAGS, *[GOOD_RATIO] * 6
    ),
    "ESTIMATOR_STATUS": lambda core, state: mavlink.MAVLink_estimator_status_message(
        microseconds(core, state), GOOD_FLAGS, *[GOOD_RATIO] * 6, 0.5, 0.5
    ),
    "EXTENDED_SYS_STATE": lambda core, state: mavlink.MAVLink_extended_sys_state_message(
        mavlink.MAV_VTOL_STATE_UNDEFINED, IN_AIR if core.airframe.flying else ON_GROUND
    ),
    "GLOBAL_POSITION_INT": lambda core, state: position_message(
        core.origin, milliseconds(core, state), state.place, state.velocity, state.yaw
    ),
    "GPS_RAW_INT": lambda core, state: mavlink.MAVLink_gps_raw_int_message(
        microseconds(core, state),
        GPS_FIX_3D,
        *on_the_wire(core.origin, state.place),
        *(80, 120),
        min(round(state.groundspeed * 100.0), UNKNOWN),
        round(math.degrees(math.atan2(state.east_rate, state.north_rate)) % 360.0 * 100.0) % 36000,
        SATELLITES,
        **GPS_ACCURACY,
    ),
    "HOME_POSITION": lambda core, state: mavlink.MAVLink_home_position_message(
        *on_the_wire(core.origin, NOTHING),
        *NOTHING,
        [1.0, *NOTHING],
        *NOTHING,
        microseconds(core, state),
    ),
    # P/GCS_MAVLink_Plane.cpp, ``send_position_target_global_int``: only the place counts
    "POSITION_TARGET_GLOBAL_INT": lambda core, state: (
        mavlink.MAVLink_position_target_global_int_message(
            milliseconds(core, state),
            mavlink.MAV_FRAME_GLOBAL,
            ONLY_PLACE,
            *on_the_wire(core.origin, core.loiter[:3])[:2],
            core.origin.place(core.loiter[:3])[2],
            *[0.0] * 8,
        )
    ),
    "SYS_STATUS": lambda core, state: mavlink.MAVLink_sys_status_message(
        SENSORS, SENSORS, SENSORS, 200, 16000, -1, 100, 0, 0, 0, 0, 0, 0
    ),
    "VFR_HUD": lambda core, state: mavlink.MAVLink_vfr_hud_message(
        core.calibrated,
        state.groundspeed,
        round(math.degrees(state.yaw)) % 360,
        round(100.0 * core.loops.throttle),
        core.origin.altitude + state.up,
        state.up_rate,
    ),
    # P/GCS_MAVLink_Plane.cpp, ``send_wind``: where it comes from, its length in space
    "WIND": lambda core, state: mavlink.MAVLink_wind_message(
        math.degrees(math.atan2(*-core.airframe.wind[:2])),
        math.hypot(*core.airframe.wind),
        -core.airframe.wind[2],
    ),
    # PX4, ``streams/WIND_COV.hpp``: where it blows to, without a vertical part
    "WIND_COV": lambda core, state: mavlink.MAVLink_wind_cov_message(
        microseconds(core, state),
        core.airframe.wind[1],
        core.airframe.wind[0],
        *(0.0, 0.02, 0.0),
        core.origin.altitude + state.up,
        *(0.0, 0.0),
    ),
}
IDS: dict[int, str] = {CURRENT_MODE: "CURRENT_MODE"} | {
    int(getattr(mavlink, f"MAVLINK_MSG_ID_{name}")): name
    for name in BUILDERS
    if name != "CURRENT_MODE"  # ArduPilot's dialect of pymavlink has no number of it
}
