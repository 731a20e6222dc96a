import math

import pytest

pytest.importorskip("rclpy")

from fault_streams import REACH, arrivals

from uav_tracking_mpc.nodes.topics import TARGET


def test_a_target_leaps_to_one_place_and_stays_there():
    places = {
        (message.point.x, message.point.y) for _, message in arrivals("target_teleport", TARGET)
    }
    ((x, y),) = places
    assert math.hypot(x - 1.0, y - 2.0) == pytest.approx(REACH)
