import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.simulation.target_motion import (
    MOTIONS,
    TargetParameters,
    target_position,
    target_velocity,
)

WAYPOINTS = (0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 30.0, 40.0, 0.0)


def moving(motion, **values):
    return TargetParameters(
        motion=motion, position=(1.0, 2.0, 3.0), speed=5.0, waypoints=WAYPOINTS, **values
    )


def test_stationary_target_stands():
    np.testing.assert_array_equal(target_position(moving("stationary"), 9.0), [1.0, 2.0, 3.0])


def test_line_runs_straight():
    line = moving("line", heading=np.pi / 2)
    np.testing.assert_allclose(target_position(line, 4.0), [1.0, 22.0, 3.0])


def test_circle_keeps_its_radius():
    circle = moving("circle", radius=50.0)
    for time in (0.0, 7.0, 100.0):
        offset = target_position(circle, time) - [1.0, 2.0, 3.0]
        assert np.linalg.norm(offset) == pytest.approx(50.0)


@pytest.mark.parametrize(
    ("time", "corner"),
    [(0.0, [0, 0, 0]), (6.0, [30, 0, 0]), (14.0, [30, 40, 0]), (24.0, [0, 0, 0])],
)
def test_waypoints_are_visited_in_turn_and_again(time, corner):
    np.testing.assert_allclose(target_position(moving("waypoints"), time), corner, atol=1e-12)


@given(st.sampled_from(MOTIONS[1:]), st.floats(0, 1000))
def test_speed_is_kept(motion, time):
    """Except across a corner, where the chord is shorter, at a stop, and in the jump itself."""
    parameters = moving(motion, jump_time=1001.0)
    dt = 1e-3
    step = target_position(parameters, time + dt) - target_position(parameters, time)
    assert np.linalg.norm(step) <= 5.0 * dt * (1 + 1e-6)
    if motion not in ("waypoints", "stop_and_go"):
        assert np.linalg.norm(step) == pytest.approx(5.0 * dt, rel=1e-6)


@pytest.mark.parametrize(
    ("time", "east"), [(0.0, 1.0), (4.0, 21.0), (6.0, 21.0), (7.0, 21.0), (8.0, 26.0), (18.0, 61.0)]
)
def test_stop_and_go_drives_and_stands_in_turn(time, east):
    target = moving("stop_and_go", drive_time=4.0, stand_time=3.0)
    np.testing.assert_allclose(target_position(target, time), [east, 2.0, 3.0])


def test_jump_is_elsewhere_at_once_and_drives_on():
    target = moving("jump", jump_time=10.0, jump_offset=(-100.0, 50.0, 5.0))
    np.testing.assert_allclose(target_position(target, 10.0 - 1e-9), [51.0, 2.0, 3.0], atol=1e-6)
    np.testing.assert_allclose(target_position(target, 10.0), [-49.0, 52.0, 8.0])
    np.testing.assert_allclose(target_position(target, 11.0), [-44.0, 52.0, 8.0])


@given(st.sampled_from(MOTIONS), st.floats(0, 1000))
def test_velocity_is_that_of_the_path(motion, time):
    """Against a difference to the future; skipped where the velocity changes within it."""
    parameters = moving(motion, jump_time=1002.0, drive_time=4.0, stand_time=3.0)
    dt = 1e-4
    velocity = target_velocity(parameters, time)
    if np.linalg.norm(target_velocity(parameters, time + dt) - velocity) > 1e-2:
        return
    ahead = target_position(parameters, time + dt) - target_position(parameters, time)
    np.testing.assert_allclose(ahead / dt, velocity, atol=1e-3)


def test_waypoints_that_are_one_point_are_refused():
    with pytest.raises(ParameterError, match="two different points"):
        TargetParameters(motion="waypoints", waypoints=(1.0, 1.0, 1.0) * 2)
