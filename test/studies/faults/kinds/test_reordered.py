import pytest

pytest.importorskip("rclpy")

from fault_streams import arrivals

from uav_tracking_mpc.nodes.topics import ODOMETRY


def test_messages_are_on_time_or_behind_later_ones():
    assert {delay for delay, _ in arrivals("odometry_reordered", ODOMETRY)} == {0.0, 0.3}
