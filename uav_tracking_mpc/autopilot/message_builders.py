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

"""Telemetry: messages of the dialect from the state of an autopilot, by name.

What both autopilots send alike; what one of them alone sends stands in its own dialect. Units and
frames are those of the MAVLink common message set.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.autopilot.autopilot_core import AutopilotCore
from uav_tracking_mpc.links.mavlink.dialect import CURRENT_MODE, mavlink

Builder = Callable[[AutopilotCore], Any]

# gyro, accelerometer, magnetometer, absolute and differential pressure, GPS, AHRS, logging
ONLY_PLACE = 0xFFF8  # type_mask
SENSORS = 0b11111 | 1 << 5 | 1 << 21
GOOD_RATIO = 0.1  # of an innovation to its gate
GPS_FIX_3D, SATELLITES = 3, 12
GPS_ACCURACY = 900, 1500, 200  # mm, mm, mm/s: horizontal, vertical, of the velocity
UNKNOWN = 65535  # of an unsigned field of 16 bits
IN_AIR, ON_GROUND = 2, 1  # MAV_LANDED_STATE


def milliseconds(core: AutopilotCore) -> int:
    """Time since boot of the state in [ms], as it fits 32 bits.

    Args:
        core: Of the vehicle.
    """
    return round((core.airframe.measured.time + core.clock_offset) * 1e3) % 2**32


def microseconds(core: AutopilotCore) -> int:
    """Time since boot of the state in [us].

    Args:
        core: Of the vehicle.
    """
    return max(round((core.airframe.measured.time + core.clock_offset) * 1e6), 0)


def _degrees(core: AutopilotCore) -> tuple[int, int, int]:
    """Latitude and longitude in [1e-7 deg] and altitude in [mm]."""
    state = core.airframe.measured
    latitude, longitude, altitude = core.origin.place([state.east, state.north, state.up])
    degrees = math.degrees(latitude), math.degrees(longitude)
    return round(degrees[0] * 1e7), round(degrees[1] * 1e7), round(altitude * 1e3)


def _heartbeat(core: AutopilotCore) -> Any:
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_FIXED_WING,
        core.traits.maker,
        int(core.base_mode),
        core.custom_mode,
        int(core.system_state),
        3,
    )


def _attitude(core: AutopilotCore) -> Any:
    state = core.airframe.measured
    return mavlink.MAVLink_attitude_message(
        milliseconds(core),
        state.roll,
        state.pitch,
        state.yaw,
        state.roll_rate,
        state.pitch_rate,
        state.yaw_rate,
    )


def _position(core: AutopilotCore) -> Any:
    state = core.airframe.measured
    latitude, longitude, altitude = _degrees(core)
    heading = round(math.degrees(state.yaw) % 360.0 * 100.0) % 36000
    return mavlink.MAVLink_global_position_int_message(
        milliseconds(core),
        latitude,
        longitude,
        altitude,
        altitude - round(core.origin.altitude * 1e3),
        round(state.north_rate * 100.0),
        round(state.east_rate * 100.0),
        round(-state.up_rate * 100.0),
        heading,
    )


def _local_position(core: AutopilotCore) -> Any:
    state = core.airframe.measured
    latitude, longitude, altitude = core.origin.place([state.east, state.north, state.up])
    north, east = core.local(latitude, longitude)
    return mavlink.MAVLink_local_position_ned_message(
        milliseconds(core),
        north,
        east,
        core.origin.altitude - altitude,
        state.north_rate,
        state.east_rate,
        -state.up_rate,
    )


def _hud(core: AutopilotCore) -> Any:
    state = core.airframe.measured
    return mavlink.MAVLink_vfr_hud_message(
        core.calibrated,
        state.groundspeed,
        round(math.degrees(state.yaw)) % 360,
        round(100.0 * core.loops.throttle),
        core.origin.altitude + state.up,
        state.up_rate,
    )


def _destination(core: AutopilotCore) -> Any:
    """P/GCS_MAVLink_Plane.cpp, ``send_position_target_global_int``: only the place counts."""
    loiter, zeros = core.loiter, [0.0] * 8
    latitude, longitude, altitude = core.origin.place([loiter.east, loiter.north, loiter.up])
    return mavlink.MAVLink_position_target_global_int_message(
        milliseconds(core),
        mavlink.MAV_FRAME_GLOBAL,
        ONLY_PLACE,
        round(math.degrees(latitude) * 1e7),
        round(math.degrees(longitude) * 1e7),
        altitude,
        *zeros,
    )


def _system_time(core: AutopilotCore) -> Any:
    return mavlink.MAVLink_system_time_message(round(time.time() * 1e6), milliseconds(core))


def _system_status(core: AutopilotCore) -> Any:
    return mavlink.MAVLink_sys_status_message(
        SENSORS, SENSORS, SENSORS, 200, 16000, -1, 100, 0, 0, 0, 0, 0, 0
    )


def _gps(core: AutopilotCore) -> Any:
    state = core.airframe.measured
    latitude, longitude, altitude = _degrees(core)
    course = math.degrees(math.atan2(state.east_rate, state.north_rate)) % 360.0
    return mavlink.MAVLink_gps_raw_int_message(
        microseconds(core),
        GPS_FIX_3D,
        latitude,
        longitude,
        altitude,
        80,
        120,
        min(round(state.groundspeed * 100.0), UNKNOWN),
        round(course * 100.0) % 36000,
        SATELLITES,
        h_acc=GPS_ACCURACY[0],
        v_acc=GPS_ACCURACY[1],
        vel_acc=GPS_ACCURACY[2],
    )


def _home(core: AutopilotCore) -> Any:
    origin = core.origin
    place = math.degrees(origin.latitude), math.degrees(origin.longitude)
    zero = (0.0, 0.0, 0.0)
    return mavlink.MAVLink_home_position_message(
        round(place[0] * 1e7),
        round(place[1] * 1e7),
        round(origin.altitude * 1e3),
        *zero,
        [1.0, 0.0, 0.0, 0.0],
        *zero,
        microseconds(core),
    )


def _global_origin(core: AutopilotCore) -> Any:
    home = _home(core)
    return mavlink.MAVLink_gps_global_origin_message(
        home.latitude, home.longitude, home.altitude, microseconds(core)
    )


def _version(core: AutopilotCore) -> Any:
    major, minor, patch = core.traits.version
    return mavlink.MAVLink_autopilot_version_message(
        core.traits.capabilities,
        major << 24 | minor << 16 | patch << 8 | mavlink.FIRMWARE_VERSION_TYPE_OFFICIAL,
        0,
        0,
        0,
        list(b"simulate"),
        [0] * 8,
        [0] * 8,
        0,
        0,
        0,
    )


def _landed(core: AutopilotCore) -> Any:
    landed = IN_AIR if core.airframe.flying else ON_GROUND
    return mavlink.MAVLink_extended_sys_state_message(mavlink.MAV_VTOL_STATE_UNDEFINED, landed)


def _navigation(core: AutopilotCore) -> Any:
    state = core.airframe.measured
    yaw = round(math.degrees(state.yaw))
    return mavlink.MAVLink_nav_controller_output_message(
        math.degrees(core.loops.roll_wanted), math.degrees(state.pitch), yaw, yaw, 0, 0.0, 0.0, 0.0
    )


def _wind(core: AutopilotCore) -> Any:
    """P/GCS_MAVLink_Plane.cpp, ``send_wind``: where it comes from, its length in space."""
    east, north, up = core.airframe.wind
    return mavlink.MAVLink_wind_message(
        math.degrees(math.atan2(-east, -north)), math.hypot(east, north, up), -up
    )


def _wind_covariance(core: AutopilotCore) -> Any:
    """PX4, ``streams/WIND_COV.hpp``: where it blows to, without a vertical part."""
    east, north, _ = core.airframe.wind
    altitude = core.origin.altitude + core.airframe.measured.up
    return mavlink.MAVLink_wind_cov_message(
        microseconds(core), north, east, 0.0, 0.02, 0.0, altitude, 0.0, 0.0
    )


def _ekf(core: AutopilotCore) -> Any:
    # attitude, velocities, horizontal positions, vertical position
    flags = 0b111111
    return mavlink.MAVLink_ekf_status_report_message(flags, *([GOOD_RATIO] * 5), GOOD_RATIO)


def _estimator(core: AutopilotCore) -> Any:
    flags = 0b111111
    return mavlink.MAVLink_estimator_status_message(
        microseconds(core), flags, *([GOOD_RATIO] * 6), 0.5, 0.5
    )


def _current_mode(core: AutopilotCore) -> Any:
    """streams/CURRENT_MODE.hpp: the mode, and that which the pilot wants."""
    return mavlink.mavlink_map[CURRENT_MODE](0, core.custom_mode, core.intended_custom_mode)


BUILDERS: dict[str, Builder] = {
    "HEARTBEAT": _heartbeat,
    "ATTITUDE": _attitude,
    "AUTOPILOT_VERSION": _version,
    "CURRENT_MODE": _current_mode,
    "EKF_STATUS_REPORT": _ekf,
    "ESTIMATOR_STATUS": _estimator,
    "EXTENDED_SYS_STATE": _landed,
    "GLOBAL_POSITION_INT": _position,
    "GPS_GLOBAL_ORIGIN": _global_origin,
    "GPS_RAW_INT": _gps,
    "HOME_POSITION": _home,
    "LOCAL_POSITION_NED": _local_position,
    "POSITION_TARGET_GLOBAL_INT": _destination,
    "NAV_CONTROLLER_OUTPUT": _navigation,
    "SYSTEM_TIME": _system_time,
    "SYS_STATUS": _system_status,
    "VFR_HUD": _hud,
    "WIND": _wind,
    "WIND_COV": _wind_covariance,
}
IDS: dict[int, str] = {CURRENT_MODE: "CURRENT_MODE"} | {
    int(getattr(mavlink, f"MAVLINK_MSG_ID_{name}")): name
    for name in BUILDERS
    if name != "CURRENT_MODE"  # ArduPilot's dialect of pymavlink has no number of it
}
