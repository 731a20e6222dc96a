import pytest

pytest.importorskip("rclpy")

from builtin_interfaces.msg import Time
from fault_streams import healthy

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.message_fields import LATEST_STAMP, numbers, shift


def test_stamps_move_as_far_as_stamps_go():
    stamp = Time(sec=100, nanosec=500_000_000)
    shift(stamp, -0.75)
    assert (stamp.sec, stamp.nanosec) == (99, 750_000_000)
    shift(stamp, 1e10)
    assert stamp.sec == LATEST_STAMP


@pytest.mark.parametrize(
    ("topic", "count"), [(ODOMETRY, 7), (TARGET, 3), (AIR_VELOCITY, 3), (COMMAND, 9)]
)
def test_numbers_can_be_set(topic, count):
    message = healthy(topic)
    fields = numbers(topic, message)
    assert len(fields) == count
    for value, (holder, name) in enumerate(fields, 1):
        setattr(holder, name, float(value))
    assert [getattr(holder, name) for holder, name in numbers(topic, message)] == [
        *range(1, count + 1)
    ]
