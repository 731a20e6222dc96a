import pytest

pytest.importorskip("rclpy")

from fault_streams import arrivals

from uav_tracking_mpc.nodes.topics import ODOMETRY


def test_jitter_is_bounded():
    delays = [delay for delay, _ in arrivals("jitter", ODOMETRY)]
    assert 0.0 <= min(delays) < 0.02
    assert 0.18 < max(delays) <= 0.2
