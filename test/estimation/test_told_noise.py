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

import pytest
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.estimation.measurement import NOISE_LIMITS, SensorNoise
from uav_tracking_mpc.estimation.told_noise import UNKNOWN, axes_noise, scalar_noise


def test_variances_become_deviations_and_an_axis_without_one_takes_the_mean():
    assert axes_noise("position", [1.0, 4.0, 9.0]) == (1.0, 2.0, 3.0)
    assert axes_noise("position", [1.0, 3.0, 0.0]) == pytest.approx((1.0, 3.0**0.5, 2.0**0.5))
    assert scalar_noise("heading", 0.01) == pytest.approx(0.1)


@pytest.mark.parametrize("wrong", [-1.0, math.nan, math.inf, 1e12])
def test_what_makes_no_sense_is_unknown(wrong):
    for axis in range(3):
        variances = [1.0, 1.0, 1.0]
        variances[axis] = wrong
        assert axes_noise("position", variances) == UNKNOWN
    assert scalar_noise("heading", wrong) == 0.0
    assert axes_noise("velocity", [0.0] * 3) == UNKNOWN


@given(st.lists(st.floats(), min_size=3, max_size=3))
def test_whatever_is_told_a_measurement_may_hold_it(variances):
    heading = scalar_noise("heading", variances[0])
    told = SensorNoise(
        axes_noise("position", variances), axes_noise("velocity", variances), heading
    )
    assert max(told.position) <= NOISE_LIMITS["position"]
