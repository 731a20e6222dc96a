"""One field of a message gone wrong: types stay, so that it could have come over the wire."""

import copy
import math
import random

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.conversions import set_command
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.mutations import mutate, scale_quaternion


def message_of(topic):
    message = topic.type()
    if topic is COMMAND:
        set_command(message, 10**9, np.full((3, 3), 0.1), 0.5)
    return message


@pytest.mark.parametrize("topic", [ODOMETRY, AIR_VELOCITY, TARGET, COMMAND])
def test_what_comes_out_can_be_sent(topic):
    rng, changed = random.Random(3), 0
    original = message_of(topic)
    for _ in range(500):
        message = copy.deepcopy(original)
        mutate(message, rng)
        received = deserialize_message(serialize_message(message), topic.type)
        changed += serialize_message(received) != serialize_message(original)
    assert changed > 300


def test_quaternions_of_every_length():
    rng, norms = random.Random(0), set()
    for _ in range(200):
        q = Quaternion(w=1.0)
        scale_quaternion(q, rng)
        norms.add(str(math.hypot(q.x, q.y, q.z, q.w)))
    assert {"0.0", "1.0", "0.5", "nan"} <= norms
