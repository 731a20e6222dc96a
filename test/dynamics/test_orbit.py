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

from uav_tracking_mpc.dynamics.orbit import Orbit


def test_radius_is_the_horizontal_distance(orbit):
    assert orbit.radius == pytest.approx(np.sqrt(150.0**2 - 50.0**2))


def test_direction_chooses_the_bearing(orbit):
    assert orbit.steady_state == pytest.approx([150.0, np.pi / 2, 50.0, 0.0, 4.0])
    assert Orbit(150.0, 50.0, 4.0, "counter_clockwise").bearing == pytest.approx(-np.pi / 2)


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ((50.0, 50.0, 4.0), "range is 50.0"),
        ((40.0, -50.0, 4.0), "range is 40.0"),
        ((np.nan, 50.0, 4.0), "range is nan"),
        ((150.0, np.inf, 4.0), "altitude is inf"),
        ((150.0, 50.0, 0.0), "speed is 0.0"),
        ((150.0, 50.0, 4.0, "left"), "direction is 'left'"),
    ],
)
def test_what_is_no_orbit_is_refused_by_name_and_value(values, name):
    with pytest.raises(ValueError, match=name):
        Orbit(*values)
