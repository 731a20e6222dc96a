import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.parameters import ParameterError
from uav_tracking_mpc.simulation.target_motion import (
    MOTIONS,
    TargetParameters,
    target_position,
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
    """Except across a corner, where the chord is shorter."""
    parameters = moving(motion)
    dt = 1e-3
    step = target_position(parameters, time + dt) - target_position(parameters, time)
    assert np.linalg.norm(step) <= 5.0 * dt * (1 + 1e-6)
    if motion != "waypoints":
        assert np.linalg.norm(step) == pytest.approx(5.0 * dt, rel=1e-6)


def test_waypoints_that_are_one_point_are_refused():
    with pytest.raises(ParameterError, match="two different points"):
        TargetParameters(motion="waypoints", waypoints=(1.0, 1.0, 1.0) * 2)
