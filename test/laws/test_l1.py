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
from small_uav import SMALL_UAV, situation

from uav_tracking_mpc.dynamics.orbit import DIRECTIONS, Orbit
from uav_tracking_mpc.laws.l1 import L1Loiter


def law(direction="clockwise", **values):
    return L1Loiter(Orbit(300.0, 120.0, 22.0, direction), SMALL_UAV, **values)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_on_the_circle_it_is_the_centripetal_acceleration(direction):
    loiter = law(direction)
    sense = 1.0 if direction == "counter_clockwise" else -1.0
    on = situation(loiter.orbit.radius, heading=sense * np.pi / 2)
    expected = sense * 22.0**2 / loiter.orbit.radius
    assert loiter.lateral_acceleration(on) == pytest.approx(expected)
    np.testing.assert_allclose(loiter.inputs(on), [expected / 22.0, 0.0, 0.0], atol=1e-12)


def test_about_the_circle_period_and_damping_are_those_of_a_pendulum():
    """Outside by e: omega^2 e more; outbound with e': 2 zeta omega e' more."""
    loiter = law("counter_clockwise", period=10.0, damping=0.8)
    omega, R, e, slip = 2 * np.pi / 10.0, loiter.orbit.radius, 2.0, 0.01
    outside = loiter.lateral_acceleration(situation(R + e, heading=np.pi / 2))
    assert outside == pytest.approx(omega**2 * e + 22.0**2 / (R + e))
    outbound = loiter.lateral_acceleration(situation(R, heading=np.pi / 2 - slip))
    speed = 22.0 * np.sin(slip)
    centripetal = (22.0 * np.cos(slip)) ** 2 / R
    assert outbound == pytest.approx(2 * 0.8 * omega * speed + centripetal)


def test_far_away_it_flies_to_the_target_by_l1():
    """A small angle nu off the line to the target: a = 4 zeta^2 v^2 / L1 sin(nu)."""
    loiter, nu = law("counter_clockwise", period=10.0, damping=0.8), 0.1
    distance = 0.8 * 10.0 * 22.0 / np.pi
    expected = 4 * 0.8**2 * 22.0**2 / distance * np.sin(nu)
    asked = loiter.lateral_acceleration(situation(5e3, heading=np.pi - nu))
    assert asked == pytest.approx(expected)
