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

"""The orbit that is flown, by numbers."""

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.flown_orbit import orbit_about
from uav_tracking_mpc.dynamics.orbit import Orbit

TARGET, VELOCITY = (10.0, 20.0, 5.0), (1.0, -2.0, 0.5)


@pytest.mark.parametrize(("direction", "sign"), [("clockwise", -1.0), ("counter_clockwise", 1.0)])
def test_that_is_the_wanted_one_in_the_map(direction: str, sign: float) -> None:
    flown = orbit_about(TARGET, VELOCITY, Orbit(50.0, 30.0, 12.0, direction))
    np.testing.assert_allclose(flown.centre, [10.0, 20.0, 35.0])
    np.testing.assert_allclose(flown.velocity, VELOCITY)
    assert flown.radius == pytest.approx(sign * 40.0)
    assert flown.airspeed == 12.0


def test_another_shape_replaces_the_wanted_one() -> None:
    flown = orbit_about(TARGET, VELOCITY, Orbit(50.0, 30.0, 12.0), shape=(100.0, 60.0, 15.0))
    assert flown.centre[2] == pytest.approx(65.0)
    assert (flown.radius, flown.airspeed) == (pytest.approx(-80.0), 15.0)
