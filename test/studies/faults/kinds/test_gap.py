import pytest

pytest.importorskip("rclpy")

from fault_streams import STREAM_FAULTS, arrivals

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET


@pytest.mark.parametrize(
    ("label", "topics"),
    [
        ("gap_state", (ODOMETRY, AIR_VELOCITY)),
        ("gap_target", (TARGET,)),
        ("gap_command", (COMMAND,)),
    ],
)
def test_a_gap_leaves_nothing(label, topics):
    assert STREAM_FAULTS[label].streams == topics
    for topic in topics:
        assert arrivals(label, topic) == []
