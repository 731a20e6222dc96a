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

"""Streams of good messages and what arrives of them under a fault, for tests."""

from __future__ import annotations

import random

import numpy as np
from filled_messages import (
    SECOND,
    filled_air,
    filled_clock,
    filled_command,
    filled_odometry,
    filled_point,
)
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.schedule import catalogue
from uav_tracking_mpc.studies.faults.stream_fault import StreamFault

FIRST = 100  # s, stamp of the first message
REACH = 150.0  # m
STATE = np.array([100.0, 0.0, 50.0, 1.0, 0.1, 4.0])
STREAM_FAULTS = {
    label: fault for label, fault in catalogue().items() if isinstance(fault, StreamFault)
}


def healthy(topic, seconds=FIRST):
    """A good message of a topic, with that stamp in [s]."""
    fill, *values = {
        ODOMETRY: (filled_odometry, STATE),
        TARGET: (filled_point, [1.0, 2.0, 0.0]),
        COMMAND: (filled_command, np.zeros((3, 3))),
        AIR_VELOCITY: (filled_air, 4.0),
        CLOCK: (filled_clock,),
    }[topic]
    return fill(seconds * SECOND, *values)


def arrivals(label, topic, count=200, seed=0):
    """(delay in [s], message) of all that arrives of one good message a second."""
    fault = STREAM_FAULTS[label]
    fault.prepare(random.Random(seed), REACH)
    return [
        (delay, deserialize_message(data, topic.type))
        for second in range(FIRST, FIRST + count)
        for delay, data in fault.deliver(topic, serialize_message(healthy(topic, second)))
    ]
