"""The bearing is that of the motion relative to the target."""

from dataclasses import replace

import numpy as np
import pytest
from example_flights import ORBIT, log_of, orbiting

from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.report.metrics import metrics


def drifting(wind, target_speed):
    """Round the orbit with the nose held into the wind: air + wind - target along the tangent."""
    log = orbiting(120)
    drift = np.asarray(wind) - target_speed
    vehicle, ground = log.vehicle.copy(), []
    for state in vehicle:
        tangent = np.array([np.cos(state[3]), np.sin(state[3])])
        along = tangent @ drift
        relative = along + np.sqrt(ORBIT.speed**2 - drift @ drift + along**2)  # wind triangle
        air = relative * tangent - drift
        state[3] = np.arctan2(air[1], air[0])
        ground.append([*(air + wind), 0.0])
    return replace(
        log,
        vehicle=vehicle,
        ground_velocity=np.array(ground),
        target_velocity=np.tile([*target_speed, 0.0], (len(ground), 1)),
    )


@pytest.mark.parametrize(
    ("wind", "target"),
    [([1.5, 0.5], [0.0, 0.0]), ([0.0, 0.0], [0.0, 1.0]), ([1.0, 0.0], [-0.5, 0.8])],
)
def test_a_perfect_orbit_in_wind_has_no_bearing_error(wind, target):
    log = drifting(np.array(wind), np.array(target))
    np.testing.assert_allclose(log.error[:, 1], 0.0, atol=1e-9)
    assert metrics(log)["settling_s"]["bearing"] == 0.0
    by_heading = replace(log, ground_velocity=None)
    assert np.max(np.abs(by_heading.error[:, 1])) > 0.1


def test_in_still_air_about_a_target_that_stands_the_heading_is_the_course():
    log = log_of(ORBIT.steady_state + np.random.default_rng(0).uniform(-1, 1, (40, 5)))
    known = replace(
        log,
        ground_velocity=np.array([velocity(state) for state in log.vehicle]),
        target_velocity=np.zeros((40, 3)),
    )
    np.testing.assert_allclose(known.error, log.error, atol=1e-12)


def test_what_does_not_move_has_the_course_of_its_nose():
    """x_o of the paper: speed 0."""
    log = replace(orbiting(5), ground_velocity=np.zeros((5, 3)))
    np.testing.assert_array_equal(log.course, log.vehicle[:, 3])
