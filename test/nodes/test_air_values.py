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

"""What diagnostics say of the air."""

import numpy as np
import pytest

from uav_tracking_mpc.estimation.wind_filter import WindFilter
from uav_tracking_mpc.nodes.air_values import air_values


def test_every_value_has_its_unit_and_is_the_filters():
    air = WindFilter()
    wind = np.array([3.0, 4.0, 0.0])
    for k in range(200):
        time = 0.05 * k
        heading = 0.07 * time
        velocity = 22.0 * np.array([np.cos(heading), np.sin(heading), 0.0])
        air.update(time, np.zeros(3), velocity + wind, velocity, 120.0)
    values = air_values(air)
    assert all(key.endswith("]") for key in values)
    assert values["mean wind north [m/s]"] == air.mean_wind[1]
    assert values["gust up [m/s]"] == air.gust[2]
    assert values["bias of ground velocity east [m/s]"] == air.ground_velocity_bias[0]
    assert values["airspeed reads too much by [%]"] == pytest.approx(100.0 * air.airspeed_share)
    assert values["bias of heading [deg]"] == pytest.approx(np.degrees(air.heading_bias))
