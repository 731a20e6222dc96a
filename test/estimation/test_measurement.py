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
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.estimation.measurement import NOISE_LIMITS, Measurement, SensorNoise


def test_the_state_has_the_airspeed_that_it_is_given():
    measurement = Measurement(1.0, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], 0.7, 0.1)
    np.testing.assert_array_equal(measurement.state(22.0), [1.0, 2.0, 3.0, 0.7, 0.1, 22.0])


def test_what_it_was_made_from_may_change_afterwards():
    position = np.zeros(3)
    measurement = Measurement(1.0, position, np.zeros(3), 0.0, 0.0)
    position += 5.0
    np.testing.assert_array_equal(measurement.position, np.zeros(3))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"stamp": np.nan}, "stamp is nan, must be a finite number"),
        ({"position": [0.0, 1.0]}, r"position is \[0.0, 1.0\], must be three finite numbers"),
        ({"ground_velocity": [0.0, np.inf, 0.0]}, "ground_velocity is .*inf"),
        ({"airspeed": -np.inf}, "airspeed is -inf"),
        ({"turn_rate": np.nan}, "turn_rate is nan"),
    ],
)
def test_what_is_no_measurement_is_refused(values, words):
    good = {"stamp": 0.0, "position": np.zeros(3), "ground_velocity": np.zeros(3)}
    with pytest.raises(ValueError, match=words):
        Measurement(**{**good, "heading": 0.0, "path_angle": 0.0, **values})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"position": (1.0, -1.0, 1.0)}, r"noise of position is .*, must be 3 in 0..100"),
        ({"position": (1.0, 1.0)}, "noise of position"),
        ({"velocity": (0.1, 0.1, np.nan)}, "noise of velocity is .*nan"),
        ({"heading": 1e6}, r"noise of heading is 1000000.0, must be 1 in 0..0.5, 0 if unknown"),
        ({"airspeed": np.inf}, "noise of airspeed is inf"),
    ],
)
def test_what_is_no_noise_is_refused(values, words):
    with pytest.raises(ValueError, match=words):
        SensorNoise(**values)


def test_an_airspeed_or_a_bank_that_is_no_number_is_not_measured():
    measured = Measurement(0.0, np.zeros(3), np.zeros(3), 0.0, 0.0, airspeed=np.nan, bank=np.nan)
    assert (measured.airspeed, measured.bank) == (None, None)


def test_variances_become_deviations_and_an_axis_without_one_takes_the_mean():
    told = SensorNoise.told([1.0, 4.0, 9.0], [1.0, 3.0, 0.0], 0.01, 0.04)
    assert told.position == (1.0, 2.0, 3.0)
    assert told.velocity == pytest.approx((1.0, 3.0**0.5, 2.0**0.5))
    assert (told.heading, told.path_angle) == pytest.approx((0.1, 0.2))


@pytest.mark.parametrize("wrong", [-1.0, math.nan, math.inf, 1e12])
def test_what_makes_no_sense_is_unknown(wrong):
    for axis in range(3):
        variances = [1.0, 1.0, 1.0]
        variances[axis] = wrong
        assert SensorNoise.told(variances, [0.0] * 3, wrong, wrong) == SensorNoise()


@given(st.lists(st.floats(), min_size=3, max_size=3))
def test_whatever_is_told_a_measurement_may_hold_it(variances):
    told = SensorNoise.told(variances, variances, *variances[:2])
    assert max(told.position) <= NOISE_LIMITS["position"]
