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

"""Parameters of the autopilot, read by name and never written."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable
from typing import Any

from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink

ROUND = 0.4  # s of waiting for answers before what is missing is asked for again
ROUNDS = 5  # an autopilot answers nothing where it has no parameter of that name
_INTEGERS = {  # how PX4 puts integers into the float of PARAM_VALUE: bit by bit
    mavlink.MAV_PARAM_TYPE_INT8: "<b",
    mavlink.MAV_PARAM_TYPE_UINT8: "<B",
    mavlink.MAV_PARAM_TYPE_INT16: "<h",
    mavlink.MAV_PARAM_TYPE_UINT16: "<H",
    mavlink.MAV_PARAM_TYPE_INT32: "<i",
    mavlink.MAV_PARAM_TYPE_UINT32: "<I",
}


def value_of(message: Any, by_bits: bool) -> float:
    """Value of a PARAM_VALUE, in the parameter's own unit.

    Args:
        message: PARAM_VALUE.
        by_bits: Whether integers travel bit by bit (MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE).
    """
    form = _INTEGERS.get(message.param_type) if by_bits else None
    if form is None:
        return float(message.param_value)
    return float(struct.unpack_from(form, struct.pack("<f", message.param_value))[0])


def read_parameters(
    connection: Connection,
    system: int,
    names: Iterable[str],
    by_bits: bool,
    receive: Callable[[float], list[Any]],
) -> dict[str, float]:
    """Read parameters by name; those that the autopilot has.

    Args:
        connection: To the autopilot.
        system: Its MAVLink system.
        names: Which to ask for.
        by_bits: See :func:`value_of`.
        receive: Gives the autopilot's messages of the next so many seconds, or earlier.

    Returns:
        Finite values by name, in the parameters' own units.
    """
    wanted = list(names)
    found: dict[str, float] = {}
    for _ in range(ROUNDS):
        missing = [name for name in wanted if name not in found]
        if not missing:
            break
        for name in missing:
            connection.send(
                mavlink.MAVLink_param_request_read_message(system, 1, name.encode("ascii"), -1)
            )
        end = connection.now() + ROUND
        while (left := end - connection.now()) > 0.0 and len(found) < len(wanted):
            for message in receive(left):
                if message.get_type() != "PARAM_VALUE" or message.param_id not in wanted:
                    continue
                value = value_of(message, by_bits)
                if math.isfinite(value):
                    found[message.param_id] = value
    return found
