import pytest

pytest.importorskip("rclpy")

from fault_streams import arrivals

from uav_tracking_mpc.nodes.topics import ODOMETRY


def test_one_message_in_five_is_lost():
    assert 0.7 < len(arrivals("loss", ODOMETRY, 1000)) / 1000 < 0.9
