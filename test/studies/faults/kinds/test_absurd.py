import numpy as np
import pytest

pytest.importorskip("rclpy")

from fault_streams import arrivals

from uav_tracking_mpc.nodes.conversions import position_from_point, vehicle_from_odometry
from uav_tracking_mpc.nodes.topics import ODOMETRY, TARGET


@pytest.mark.parametrize(
    ("label", "topic", "read"),
    [
        ("odometry_absurd", ODOMETRY, vehicle_from_odometry),
        ("target_absurd", TARGET, position_from_point),
    ],
)
def test_absurd_places_pass_every_check_of_a_single_message(label, topic, read):
    values = np.array([read(message) for _, message in arrivals(label, topic)])
    assert np.all(np.isfinite(values))
    assert np.max(np.abs(values)) > 1e6
