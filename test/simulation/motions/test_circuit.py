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


import numpy as np
import pytest

from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions.circuit import Circle, Waypoints


@pytest.mark.parametrize("time", [0.0, 7.0, 100.0])
def test_it_keeps_its_radius_and_its_height(time):
    circle = Circle(TargetParameters(position=(1.0, 2.0, 3.0), speed=5.0, radius=50.0))
    east, north, up = circle.position(time) - [1.0, 2.0, 3.0]
    assert np.hypot(east, north) == pytest.approx(50.0)
    assert up == 0.0
    assert np.linalg.norm(circle.velocity(time)) == pytest.approx(5.0)


def test_it_starts_at_its_heading_and_turns_counter_clockwise():
    circle = Circle(TargetParameters(speed=np.pi, radius=1.0, heading=np.pi / 2))
    np.testing.assert_allclose(circle.position(0.0), [0.0, 1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(circle.position(0.5), [-1.0, 0.0, 0.0], atol=1e-12)


CORNERS = (0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 30.0, 40.0, 0.0)
TARGET = Waypoints(TargetParameters(speed=5.0, waypoints=CORNERS))


@pytest.mark.parametrize(
    ("time", "corner"),
    [(0.0, [0, 0, 0]), (6.0, [30, 0, 0]), (14.0, [30, 40, 0]), (24.0, [0, 0, 0])],
)
def test_they_are_visited_in_turn_and_again(time, corner):
    np.testing.assert_allclose(TARGET.position(time), corner, atol=1e-12)


@pytest.mark.parametrize(
    ("time", "velocity"),
    [(0.0, [5, 0, 0]), (6.0, [0, 5, 0]), (13.9, [0, 5, 0]), (14.0, [-3, -4, 0])],
)
def test_at_a_corner_the_velocity_is_the_one_after_it(time, velocity):
    np.testing.assert_allclose(TARGET.velocity(time), velocity, atol=1e-12)
