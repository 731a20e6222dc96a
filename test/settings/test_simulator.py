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


import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters, TargetParameters


@pytest.mark.parametrize(
    ("values", "name"),
    [
        ({"speed_min": 9.0, "speed_max": 8.0}, "speed_min"),
        ({"initial_speed": 30.0}, "initial_speed"),
    ],
)
def test_limits_that_do_not_fit_are_named(values, name):
    with pytest.raises(ParameterError, match=name):
        SimulatorParameters(**values)


@pytest.mark.parametrize("waypoints", [(), (1.0, 1.0, 1.0), (1.0, 1.0, 1.0) * 2])
def test_waypoints_that_are_one_point_are_refused(waypoints):
    with pytest.raises(ParameterError, match="two different points"):
        TargetParameters(waypoints=waypoints)
