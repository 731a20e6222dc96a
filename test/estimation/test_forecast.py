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

from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.estimation.situation import Situation


def test_a_steady_forecast_is_the_present_at_every_stage():
    target, drift = np.array([3.0, -4.0, 1.0]), np.array([5.0, 2.0, -0.5])
    now = Situation(np.zeros(6), target, drift, np.array([0.3, 0.0, 0.0]), np.zeros(3))
    forecast = steady_forecast(now, 7)
    np.testing.assert_array_equal(forecast.target, [target] * 8)
    np.testing.assert_array_equal(forecast.drift, [drift] * 8)
    np.testing.assert_array_equal(forecast.drift_rate, np.zeros((8, 3)))
