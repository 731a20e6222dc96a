import pytest

pytest.importorskip("rclpy")

from fault_streams import arrivals

from uav_tracking_mpc.nodes.topics import ODOMETRY


def test_every_message_comes_three_times():
    heard = arrivals("odometry_duplicated", ODOMETRY, 100)
    assert len(heard) == 300
    assert all(0.0 <= delay <= 0.3 for delay, _ in heard)
    assert {message.header.stamp.sec for _, message in heard[:3]} == {100}
