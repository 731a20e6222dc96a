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

"""What ArduPlane is told and how it speaks: parameters that matter to a companion, as of 4.6."""

from __future__ import annotations

import math

from uav_tracking_mpc.autopilot.dialects._vehicle_numbers import vehicle_numbers
from uav_tracking_mpc.autopilot.numbers import Result
from uav_tracking_mpc.autopilot.wire_traits import WireTraits
from uav_tracking_mpc.settings.configuration import Configuration

LOITER_RADIUS = 60  # m, WP_LOITER_RAD where the aircraft is slow enough for it

# SRx_POSITION, _EXTRA1 to _EXTRA3, _EXT_STAT as ground stations set them, in Hz
STREAM_RATES = {
    "GLOBAL_POSITION_INT": 4.0, "LOCAL_POSITION_NED": 4.0, "ATTITUDE": 10.0, "VFR_HUD": 10.0,
    "WIND": 4.0, "SYSTEM_TIME": 4.0, "EKF_STATUS_REPORT": 4.0, "SYS_STATUS": 4.0,
    "GPS_RAW_INT": 4.0, "NAV_CONTROLLER_OUTPUT": 4.0,
}  # fmt: skip
ARDUPILOT_TRAITS = WireTraits(
    maker=3,  # MAV_AUTOPILOT_ARDUPILOTMEGA
    version=(4, 6, 0),
    # MISSION_FLOAT, PARAM_FLOAT, MISSION_INT, COMMAND_INT, SET_ATTITUDE_TARGET,
    # SET_POSITION_TARGET_GLOBAL_INT, MAVLINK2: P/GCS_MAVLink_Plane.cpp, ``capabilities``
    capabilities=1 | 2 | 4 | 8 | 64 | 256 | 8192,
    stream_rates=STREAM_RATES,
    mode_messages=("HEARTBEAT",),  # P/system.cpp, Plane::set_mode
    lacking=("CURRENT_MODE", "ESTIMATOR_STATUS", "WIND_COV"),
    sync_period=10.0,
    unknown_message=Result.FAILED,
    hears_all=True,
    bytewise=False,
    set_mode_acknowledged=11,  # MAVLINK_MSG_ID_SET_MODE
)


def ardupilot_parameters(configuration: Configuration, density_factor: float) -> dict[str, float]:
    """Values at the start by name [-]; an integer is one of ArduPlane's too.

    Args:
        configuration: Of the aircraft.
        density_factor: True over equivalent airspeed there [-].
    """
    own = vehicle_numbers(configuration, density_factor)
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
