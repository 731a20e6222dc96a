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
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.messages.conversions import (
    set_air_velocity,
    set_command,
    set_odometry,
    set_point,
    set_stamp,
)
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
    message, stamp = topic.type(), seconds * 10**9
    if topic is ODOMETRY:
        set_odometry(message, stamp, STATE, np.zeros(3))
    elif topic is TARGET:
        set_point(message, stamp, np.array([1.0, 2.0, 0.0]))
    elif topic is COMMAND:
        set_command(message, stamp, np.zeros((3, 3)), 1.0)
    elif topic is AIR_VELOCITY:
        set_air_velocity(message, stamp, 4.0)
    else:
        assert topic is CLOCK
        set_stamp(message.clock, stamp)
    return message


def arrivals(label, topic, count=200, seed=0):
    """(delay in [s], message) of all that arrives of one good message a second."""
    fault = STREAM_FAULTS[label]
    fault.prepare(random.Random(seed), REACH)
    return [
        (delay, deserialize_message(data, topic.type))
        for second in range(FIRST, FIRST + count)
        for delay, data in fault.deliver(topic, serialize_message(healthy(topic, second)))
    ]
