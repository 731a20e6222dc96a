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
import small_uav
from small_uav import SMALL_UAV, fly

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.laws import altitude_hold
from uav_tracking_mpc.laws.l1 import L1Loiter

ORBIT = Orbit(300.0, 120.0, 22.0)
RADIUS = ORBIT.radius


def situation(height=120.0, path_angle=0.0, speed=22.0, climb=0.0):
    drift = (0.0, 0.0, climb)
    return small_uav.situation(RADIUS, 0.0, height, -np.pi / 2, path_angle, speed, drift=drift)


def test_it_leads_back_to_the_orbit_and_follows_a_target_that_climbs():
    assert altitude_hold(ORBIT, SMALL_UAV, situation()) == (0.0, 0.0)
    low_and_slow = altitude_hold(ORBIT, SMALL_UAV, situation(height=110.0, speed=20.0))
    assert min(low_and_slow) > 0.0
    # steady where v sin(chi) makes up for the vertical drift
    following = situation(path_angle=np.arcsin(1.5 / 22.0), climb=-1.5)
    assert altitude_hold(ORBIT, SMALL_UAV, following)[0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("height", [60.0, 110.0, 180.0])
def test_a_step_is_taken_without_overshoot_at_constant_airspeed(height):
    start = situation(height=height).vehicle
    offsets, vehicles, _ = fly(L1Loiter(ORBIT, SMALL_UAV), start, 60.0)
    error = (offsets[:, 2] - 120.0) * np.sign(height - 120.0)
    assert error.min() > -0.1
    assert abs(error[-1]) < 0.01
    np.testing.assert_allclose(vehicles[:, 5], 22.0, atol=1e-9)


def test_no_climb_is_steeper_than_the_thrust_sustains():
    weak = small_uav.parameters("force_max=[1.0, 0.3]").envelope
    _, vehicles, _ = fly(L1Loiter(ORBIT, weak), situation(height=40.0).vehicle, 30.0)
    assert vehicles[:, 4].max() == pytest.approx(np.arcsin(weak.force_limits(22.0)[1] / GRAVITY))
    np.testing.assert_allclose(vehicles[:, 5], 22.0, atol=1e-9)


def test_the_floor_comes_before_the_target():
    """A target that descends below is not followed through the floor."""
    law = L1Loiter(ORBIT, SMALL_UAV)
    _, vehicles, _ = fly(law, situation().vehicle, 120.0, target_velocity=(0.0, 0.0, -1.5))
    assert vehicles[:, 2].min() > SMALL_UAV.height_min - 0.1
    assert vehicles[-1, 2] == pytest.approx(SMALL_UAV.height_min, abs=0.1)
