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

"""Numbers of the MAVLink vocabulary that the autopilot's core speaks; the wire has the others."""

from __future__ import annotations

from enum import IntEnum, IntFlag
from typing import NamedTuple


class Result(IntEnum):
    """MAV_RESULT: what becomes of a command."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4


class Frame(IntEnum):
    """MAV_FRAME, as far as altitudes are told in them."""

    GLOBAL = 0
    GLOBAL_RELATIVE_ALT = 3
    GLOBAL_INT = 5
    GLOBAL_RELATIVE_ALT_INT = 6


class Cmd(IntEnum):
    """MAV_CMD, those that are understood."""

    NAV_LOITER_UNLIM = 17
    NAV_RETURN_TO_LAUNCH = 20
    NAV_TAKEOFF = 22
    DO_SET_MODE = 176
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_CHANGE_ALTITUDE = 186
    DO_REPOSITION = 192
    COMPONENT_ARM_DISARM = 400
    GET_HOME_POSITION = 410
    SET_MESSAGE_INTERVAL = 511
    REQUEST_MESSAGE = 512
    REQUEST_AUTOPILOT_CAPABILITIES = 520
    GUIDED_CHANGE_SPEED = 43000
    GUIDED_CHANGE_ALTITUDE = 43001
    GUIDED_CHANGE_HEADING = 43002


class Severity(IntEnum):
    """MAV_SEVERITY of a text."""

    EMERGENCY = 0
    CRITICAL = 2
    WARNING = 4
    NOTICE = 5
    INFO = 6


class SystemState(IntEnum):
    """MAV_STATE of the vehicle."""

    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5
    EMERGENCY = 6


class BaseMode(IntFlag):
    """MAV_MODE_FLAG of the vehicle."""

    CUSTOM = 1
    AUTO = 4
    GUIDED = 8
    STABILIZE = 16
    MANUAL_INPUT = 64
    ARMED = 128


class Order(NamedTuple):
    """A command as it came, COMMAND_LONG and COMMAND_INT alike.

    Attributes:
        command: MAV_CMD.
        param1: Its first value, in its own unit, [-].
        param2: Second [-].
        param3: Third [-].
        param4: Fourth [-].
        x: Latitude in [deg] where the command has a place, else its fifth value [-].
        y: Longitude in [deg], or the sixth value [-].
        z: Altitude in [m], or the seventh value [-].
        frame: MAV_FRAME of the place.
    """

    command: int
    param1: float = 0.0
    param2: float = 0.0
    param3: float = 0.0
    param4: float = 0.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    frame: int = Frame.GLOBAL_RELATIVE_ALT


class AttitudeTarget(NamedTuple):
    """SET_ATTITUDE_TARGET, decoded.

    Attributes:
        mask: type_mask as on the wire: a bit that is set leaves its part out.
        roll: Of the quaternion in [rad], positive to the right.
        pitch: Of the quaternion in [rad], positive up.
        thrust: From 0 to 1 [-].
    """

    mask: int
    roll: float
    pitch: float
    thrust: float
