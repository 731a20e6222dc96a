# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""The bearing is that of the motion relative to the target."""

from dataclasses import replace

import numpy as np
import pytest
from example_flights import ORBIT, log_of, orbiting

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.report.metrics import metrics
from uav_tracking_mpc.simulation.flight_log import FlownMode


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


def test_a_reference_that_changed_counts_from_when_it_did():
    log = orbiting(120)
    begin, wide = log.time[60], replace(ORBIT, range=ORBIT.range + 7.0)
    steered = replace(log, orbit=wide, orbits=((0.4, ORBIT), (begin, wide)))
    np.testing.assert_allclose(steered.error[:60], log.error[:60])
    np.testing.assert_allclose(steered.error[60:, 0], log.error[60:, 0] - 7.0)
    np.testing.assert_allclose(steered.reference[[0, 59], 0], ORBIT.range)
    np.testing.assert_allclose(steered.radius[[59, 60]], [ORBIT.radius, wide.radius])
    assert metrics(log)["settling_s"]["range"] == 0.0
    assert metrics(steered)["settling_s"]["range"] is None


def test_the_wind_is_what_air_and_ground_leave_between_them():
    wind, target = np.array([1.5, 0.5]), np.array([0.0, 1.0])
    log = drifting(wind, target)
    np.testing.assert_allclose(log.wind, [[1.5, 0.5, 0.0]] * len(log.time), atol=1e-9)
    np.testing.assert_allclose(log.drift, [[1.5, -0.5, 0.0]] * len(log.time), atol=1e-9)
    assert not orbiting(5).wind.any()


def test_the_bank_is_that_of_the_turn_right_wing_down():
    """As it was recorded, else from the headings; the paper's orbit is clockwise."""
    log = orbiting(100, step=0.5)
    expected = np.arctan(ORBIT.speed**2 / (GRAVITY * ORBIT.radius))
    np.testing.assert_allclose(log.bank, expected, rtol=1e-6)
    recorded = replace(log, turn_rate=np.full(100, GRAVITY / ORBIT.speed))
    np.testing.assert_allclose(recorded.bank, -0.25 * np.pi)
    assert len(orbiting(1).bank) == 1 and len(orbiting(0).bank) == 0


def test_modes_over_time():
    optimal = FlownMode(0.5, FallbackMode.OPTIMAL)
    loiter = FlownMode(2.0, FallbackMode.LOITER, "target position is lost")
    log = orbiting(5, modes=(optimal, loiter))
    assert [log.mode_at(time) for time in (0.0, 0.5, 1.9, 2.0, 9.0)] == [
        None, optimal, optimal, loiter, loiter,
    ]  # fmt: skip
    assert log.mode_spans == [(0.5, 2.0, optimal), (2.0, 4.0, loiter)]
    assert orbiting(5).mode_spans == [] and orbiting(5).mode_at(1.0) is None
