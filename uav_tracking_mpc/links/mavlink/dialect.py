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

"""pymavlink, in one place: MAVLink 2, with ArduPilot's messages beside the common ones."""

from __future__ import annotations

import os
from types import SimpleNamespace
from typing import Any

from uav_tracking_mpc.links import LinkError

os.environ.setdefault("MAVLINK20", "1")  # pymavlink reads it once, when it is imported
try:
    from pymavlink.dialects.v20 import ardupilotmega, development
except ImportError as error:
    raise LinkError('MAVLink needs pymavlink: pip install "uav_tracking_mpc[mavlink]"') from error

mavlink: Any = ardupilotmega
# PX4 sends it, the dialect of ArduPilot does not have it.
CURRENT_MODE: int = development.MAVLINK_MSG_ID_CURRENT_MODE
mavlink.mavlink_map.setdefault(CURRENT_MODE, development.MAVLink_current_mode_message)


def name_of(enumeration: str, value: int) -> str:
    """Name of a value of an enumeration without the enumeration's own, such as ``FIXED_WING``.

    Args:
        enumeration: Such as ``MAV_TYPE``.
        value: One of its values; others are told as numbers.
    """
    entry = mavlink.enums.get(enumeration, {}).get(value)
    return str(value) if entry is None else str(entry.name).removeprefix(f"{enumeration}_")


def values_of(enumeration: str) -> Any:
    """Values of an enumeration by name without the enumeration's own, such as ``FIXED_WING``.

    Args:
        enumeration: Such as ``MAV_TYPE``.
    """
    entries = mavlink.enums[enumeration].items()
    return SimpleNamespace(**{e.name.removeprefix(f"{enumeration}_"): v for v, e in entries})
