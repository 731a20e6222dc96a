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

import math

import numpy as np
import pytest
from small_uav import SMALL_UAV, fly, range_errors, situation

from uav_tracking_mpc.dynamics.orbit import DIRECTIONS, Orbit
from uav_tracking_mpc.dynamics.vehicle import advance
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws.vector_field import VectorField


def law(direction="clockwise", **values):
    return VectorField(Orbit(300.0, 120.0, 22.0, direction), SMALL_UAV, **values)


def test_far_away_it_points_inwards_on_the_circle_along_it_near_the_centre_outwards():
    for direction, along in (("clockwise", -np.pi / 2), ("counter_clockwise", np.pi / 2)):
        field = law(direction)
        for distance, course in ((1e7, np.pi), (field.orbit.radius, along), (1e-4, 0.0)):
            wanted = field.heading(situation(distance, 0.0))[0]
            assert math.remainder(wanted - course, 2 * np.pi) == pytest.approx(0.0, abs=1e-4)


def test_a_circulation_of_one_is_the_field_of_2008():
    """Frew, Lawrence and Morris: -(x (d^2-R^2) + 2 y R d, y (d^2-R^2) - 2 x R d), clockwise: +-."""
    field = law("counter_clockwise", circulation=1.0)
    R = field.orbit.radius
    for x, y in ((100.0, 50.0), (-300.0, 200.0), (20.0, -700.0)):
        d = math.hypot(x, y)
        ux = -(x * (d * d - R * R) + 2 * y * R * d)
        uy = -(y * (d * d - R * R) - 2 * x * R * d)
        assert math.hypot(ux, uy) == pytest.approx(d * (d * d + R * R))
        wanted = field.heading(situation(x, y))[0]
        assert math.remainder(wanted - math.atan2(uy, ux), 2 * np.pi) == pytest.approx(0, abs=1e-9)


def test_the_heading_gives_the_relative_velocity_the_direction_of_the_field():
    drift = (6.0, -9.0, 0.0)
    still, drifted = (
        law().heading(situation(310.0, -40.0, drift=c))[0] for c in ((0, 0, 0), drift)
    )
    relative = 22.0 * np.array([np.cos(drifted), np.sin(drifted)]) + drift[:2]
    assert math.atan2(relative[1], relative[0]) == pytest.approx(still)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_feed_forward_is_the_derivative_along_the_motion(direction):
    """Central difference over a turning, climbing, accelerating flight in a changing drift."""
    field = law(direction)
    start = np.array([180.0, -240.0, 100.0, 0.4, 0.1, 21.0])
    rates, drift, drift_rate = np.array([[0.2, 0.04, 0.5], [5.0, -6.0, 0.5], [0.3, 0.2, 0.0]])

    def at(time):
        vehicle = advance(start, rates, time)
        vehicle[:3] += drift * time + 0.5 * drift_rate * time**2
        return Situation(vehicle, np.zeros(3), drift + drift_rate * time, drift_rate, rates)

    h = 1e-4
    difference = field.heading(at(h))[0] - field.heading(at(-h))[0]
    assert field.heading(at(0.0))[1] == pytest.approx(difference / (2 * h), rel=1e-6)


def test_a_drift_almost_as_fast_as_the_aircraft_is_borne():
    field = law()
    offsets, _, inputs = fly(field, [500.0, 0.0, 120.0, 0.0, 0.0, 22.0], 250.0, (19.5, 0.0, 0.0))
    assert np.all(np.isfinite(inputs))
    assert np.abs(range_errors(field, offsets)[-1000:]).max() < 30.0
