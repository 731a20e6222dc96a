import pytest

pytest.importorskip("rclpy")

from fault_streams import FIRST, arrivals

from uav_tracking_mpc.nodes.topics import CLOCK


@pytest.mark.parametrize(("label", "sign"), [("clock_forward", 1), ("clock_backward", -1)])
def test_the_clock_jumps_by_one_offset_and_never_below_zero(label, sign):
    offsets = set()
    for seed in range(20):
        seconds = [message.clock.sec for _, message in arrivals(label, CLOCK, seed=seed)]
        assert min(seconds) >= 0
        if min(seconds) > 0:
            ((offset),) = {second - true for true, second in enumerate(seconds, FIRST)}
            offsets.add(offset)
    assert offsets
    assert all(sign * offset > 0 for offset in offsets)
