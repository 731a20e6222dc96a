import random

import numpy as np
import pytest

pytest.importorskip("rclpy")

from rclpy.serialization import serialize_message
from test_message_faults import Message

from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    plan_from_command,
    position_from_point,
    set_air_velocity,
    set_command,
    set_odometry,
    set_point,
    vehicle_from_odometry,
)
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.corruption import LATEST_STAMP, corrupt, shift
from uav_tracking_mpc.studies.faults.fault_kinds import KINDS, ORDERINGS

STATE = np.array([100.0, 0.0, 50.0, 1.0, 0.1, 4.0])
PREFIXES = {
    "odometry": ODOMETRY,
    "target": TARGET,
    "command": COMMAND,
    "air_velocity": AIR_VELOCITY,
}
CASES = [
    (topic, name.removeprefix(f"{prefix}_"))
    for prefix, topic in PREFIXES.items()
    for name, kind in KINDS.items()
    if kind.family == prefix
    and name.startswith(f"{prefix}_")
    and not name.endswith((*ORDERINGS, "teleport", "lost"))
]


def healthy(topic):
    message = topic.type()
    if topic is ODOMETRY:
        set_odometry(message, 10**11, STATE, np.zeros(3))
    elif topic is TARGET:
        set_point(message, 10**11, np.zeros(3))
    elif topic is COMMAND:
        set_command(message, 10**11, np.zeros((3, 3)), 1.0)
    else:
        set_air_velocity(message, 10**11, 4.0)
    return message


def read(topic, message):
    if topic is ODOMETRY:
        return vehicle_from_odometry(message)
    if topic is TARGET:
        return position_from_point(message)
    return plan_from_command(message)[0]


@pytest.mark.parametrize(("topic", "name"), CASES, ids=lambda case: getattr(case, "name", case))
def test_a_corrupted_message_still_goes_over_the_wire(topic, name):
    for seed in range(20):
        message = healthy(topic)
        corrupt(topic.name, name, message, random.Random(seed))
        assert serialize_message(message) != serialize_message(healthy(topic))


@pytest.mark.parametrize("name", ["nan", "inf", "frame"])
@pytest.mark.parametrize("topic", [ODOMETRY, TARGET, COMMAND])
def test_what_nobody_may_fly_on_is_refused(topic, name):
    for seed in range(30):
        message = healthy(topic)
        corrupt(topic.name, name, message, random.Random(seed))
        with pytest.raises(MessageError):
            read(topic, message)


@pytest.mark.parametrize("topic", [ODOMETRY, TARGET])
def test_absurd_is_finite_and_passes_every_check_of_a_single_message(topic):
    message = healthy(topic)
    corrupt(topic.name, "absurd", message, random.Random(0))
    assert np.all(np.isfinite(read(topic, message)))


def test_stamps_move_as_far_as_stamps_go():
    stamp = Message(sec=100, nanosec=500_000_000)
    shift(stamp, -0.75)
    assert (stamp.sec, stamp.nanosec) == (99, 750_000_000)
    shift(stamp, 1e10)
    assert stamp.sec == LATEST_STAMP
