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

"""What PX4 is told and how it speaks: parameters that matter to a companion, as of 1.16."""

from __future__ import annotations

from uav_tracking_mpc.autopilot.dialects._vehicle_numbers import vehicle_numbers
from uav_tracking_mpc.autopilot.numbers import Result
from uav_tracking_mpc.autopilot.wire_traits import WireTraits
from uav_tracking_mpc.settings.configuration import Configuration

LOITER_RADIUS = 80  # m, NAV_LOITER_RAD where the aircraft is slow enough for it
# mavlink_main.cpp, configure_streams_to_default, MAVLINK_MODE_ONBOARD, in Hz
STREAM_RATES = {
    "GLOBAL_POSITION_INT": 50.0, "LOCAL_POSITION_NED": 30.0, "ATTITUDE": 100.0, "VFR_HUD": 10.0,
    "WIND_COV": 10.0, "SYSTEM_TIME": 1.0, "ESTIMATOR_STATUS": 1.0, "SYS_STATUS": 5.0,
    "GPS_RAW_INT": 10.0, "NAV_CONTROLLER_OUTPUT": 10.0, "EXTENDED_SYS_STATE": 5.0,
    "GPS_GLOBAL_ORIGIN": 1.0, "HOME_POSITION": 0.5, "CURRENT_MODE": 0.5,
}  # fmt: skip
PX4_TRAITS = WireTraits(
    maker=12,  # MAV_AUTOPILOT_PX4
    version=(1, 16, 0),
    # MISSION_FLOAT, MISSION_INT, COMMAND_INT, PARAM_ENCODE_BYTEWISE, SET_ATTITUDE_TARGET,
    # SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT, MAVLINK2
    capabilities=1 | 4 | 8 | 16 | 64 | 128 | 256 | 8192,
    stream_rates=STREAM_RATES,
    mode_messages=(),  # streams/HEARTBEAT.hpp: a constant rate, whatever happens
    lacking=("EKF_STATUS_REPORT", "POSITION_TARGET_GLOBAL_INT", "WIND"),
    sync_period=0.1,
    unknown_message=Result.DENIED,
    hears_all=False,  # Commander.cpp, evaluate_target_ok
    bytewise=True,
    set_mode_acknowledged=176,  # MAV_CMD_DO_SET_MODE, into which it is turned
)


def px4_parameters(configuration: Configuration, density_factor: float) -> dict[str, float]:
    """Values at the start by name [-]; an integer is one of PX4's too.

    Args:
        configuration: Of the aircraft.
        density_factor: True over equivalent airspeed there [-].
    """
    own = vehicle_numbers(configuration, density_factor)
    return {
        "COM_DL_LOSS_T": 10,
        "COM_FAIL_ACT_T": 5.0,
        "COM_OBL_RC_ACT": 5,  # Hold: as it is to be set; PX4's own default 0 is refused by the link
        "COM_OF_LOSS_T": 1.0,
        "COM_RCL_EXCEPT": 0,
        "COM_RC_IN_MODE": 3,
        "COM_RC_LOSS_T": 0.5,
        "COM_RC_OVERRIDE": 1,
        "FW_AIRSPD_MAX": round(own.fastest, 2),
        "FW_AIRSPD_MIN": round(own.slowest, 2),
        "FW_AIRSPD_STALL": round(0.7 * own.slowest, 2),
        "FW_AIRSPD_TRIM": own.cruise,
        "FW_PSP_OFF": 0.0,
        "FW_P_LIM_MAX": 30.0,
        "FW_P_LIM_MIN": -30.0,
        "FW_P_RMAX_NEG": 60.0,
        "FW_P_RMAX_POS": 60.0,
        "FW_P_TC": 0.4,
        "FW_R_LIM": own.bank_max,
        "FW_R_RMAX": float(own.roll_rate),
        "FW_R_TC": 0.4,
        "FW_THR_ASPD_MAX": 0.0,
        "FW_THR_ASPD_MIN": 0.0,
        "FW_THR_IDLE": 0.0,
        "FW_THR_MAX": 1.0,
        "FW_THR_MIN": 0.0,
        "FW_THR_SLEW_MAX": 0.0,
        "FW_THR_TRIM": 0.6,
        "FW_T_ALT_TC": 5.0,
        "FW_T_CLMB_MAX": own.climb_max,
        "FW_T_CLMB_R_SP": min(3.0, own.climb_max),
        "FW_T_RLL2THR": 15.0,
        "FW_T_SINK_MAX": own.sink_max,
        "FW_T_SINK_MIN": own.sink_idle,
        "FW_T_SINK_R_SP": min(2.0, own.sink_max),
        "FW_T_TAS_TC": 5.0,
        "FW_USE_AIRSPD": 1,
        "FW_Y_RMAX": 50.0,
        "GF_ACTION": 2,
        "GF_MAX_HOR_DIST": 0.0,
        "GF_MAX_VER_DIST": 0.0,
        "MAV_COMP_ID": 1,
        "MAV_FWDEXTSP": 1,
        "MAV_SYS_ID": 1,
        "MAV_TYPE": 1,
        "MIS_TAKEOFF_ALT": 30.0,
        "NAV_DLL_ACT": 0,
        "NAV_LOITER_RAD": float(max(LOITER_RADIUS, own.radius)),
        "NAV_RCL_ACT": 2,
        "NPFG_DAMPING": 0.7,
        "NPFG_PERIOD": 10.0,
        "RTL_LOITER_RAD": float(max(LOITER_RADIUS, own.radius)),
        "RTL_RETURN_ALT": 60.0,
        "RTL_TYPE": 0,
        "SYS_HAS_NUM_ASPD": 1,
        "WEIGHT_BASE": -1.0,
        "WEIGHT_GROSS": -1.0,
    }
