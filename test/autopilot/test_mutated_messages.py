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

"""Whatever comes over the wire, the autopilot flies on."""

import math
import random
import re

import pytest
from autopilot_steps import autopilot

from uav_tracking_mpc.autopilot.dialects.ardupilot import ArduPlane
from uav_tracking_mpc.autopilot.dialects.px4 import Px4
from uav_tracking_mpc.autopilot.numbers import Cmd
from uav_tracking_mpc.autopilot.vehicle_protocol import VehicleProtocol
from uav_tracking_mpc.links.mavlink.dialect import mavlink

FLOATS = (math.nan, math.inf, -math.inf, 0.0, -1.0, 1.0, 1e-30, 1e9, -1e9, 3.4e38, -3.4e38, 15.0)
TAKEN = (
    "COMMAND_INT", "COMMAND_LONG", "HEARTBEAT", "PARAM_REQUEST_READ", "PARAM_SET",
    "SET_ATTITUDE_TARGET", "SET_MODE", "TIMESYNC",
)  # fmt: skip
ARRAYS = {"q": 4}
MESSAGES = 1500


def number(type_, rng):
    if type_ == "float":
        return rng.choice(FLOATS)
    bits = int(re.search(r"\d+", type_)[0])
    lowest = 0 if type_[0] == "u" else -(2 ** (bits - 1))
    return rng.choice([lowest, lowest + 2**bits - 1, 0, 1, rng.randrange(lowest, lowest + 2**bits)])


def mutated(rng, names):
    name = rng.choice(TAKEN)
    kind = getattr(mavlink, f"MAVLink_{name.lower()}_message")
    values = []
    for field, type_ in zip(kind.fieldnames, kind.fieldtypes, strict=True):
        if field in ("target_system", "target_component"):
            values.append(1)
        elif field == "command":
            values.append(int(rng.choice(list(Cmd))))
        elif type_ == "char":
            values.append(rng.choice(names).encode())
        elif field in ARRAYS:
            values.append([number(type_, rng) for _ in range(ARRAYS[field])])
        else:
            values.append(number(type_, rng))
    return kind(*values)


@pytest.mark.parametrize("dialect", [ArduPlane, Px4])
def test_no_message_ends_the_flight(dialect):
    protocol = VehicleProtocol(autopilot(dialect))
    core, rng = protocol.core, random.Random(1)
    sender, parser = mavlink.MAVLink(None, 255, 1), mavlink.MAVLink(None)
    for _ in range(MESSAGES):
        message = mutated(rng, core.parameters.names)
        for heard in parser.parse_buffer(message.pack(sender)) or []:
            protocol.take(heard, core.time)
        protocol.advance(core.time + 0.01)
        for answer in protocol.outgoing():
            assert answer.pack(sender)
        assert all(map(math.isfinite, core.state))
    assert core.time == pytest.approx(0.01 * MESSAGES)
