from uav_tracking_mpc.nodes.stall_guard import DRAIN, StallGuard


def test_what_is_heard_first_after_a_stall_is_old():
    guard = StallGuard(0.4)
    assert guard.alive(10.0)
    assert guard.alive(10.39)
    assert not guard.alive(12.0)  # stopped for 1.6 s
    assert not guard.alive(12.0 + 0.9 * DRAIN)
    assert guard.alive(12.0 + 1.1 * DRAIN)
    assert guard.stalls == 1


def test_a_first_message_is_no_stall():
    assert StallGuard(0.4).alive(1e6)
