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

"""What every law owes: it converges, and answers anything finite inside the envelope."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_uav import SMALL_UAV, fly, range_errors

from uav_tracking_mpc.dynamics.orbit import DIRECTIONS, Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import GUIDANCE_LAW

WIND, RUN = (8.0, 0.0, 0.0), (0.0, 5.0, 0.0)
TIMES = {"l1": (110.0, 0.5), "npfg": (140.0, 0.5), "vector_field": (110.0, 0.05)}  # s, and m
numbers = st.floats(allow_nan=False, allow_infinity=False)


def law(name, direction="clockwise"):
    return GUIDANCE_LAW.find(name)(Orbit(300.0, 120.0, 22.0, direction), SMALL_UAV)


STARTS = (
    [700.0, 0.0, 120.0, 0.0, 0.0, 22.0],
    [0.0, 0.0, 90.0, 1.0, 0.0, 22.0],
    [-280.0, 0.0, 180.0, np.pi / 2, 0.1, 30.0],
    [-200.0, -900.0, 60.0, -1.0, 0.0, 16.0],
)


@pytest.mark.parametrize("name", GUIDANCE_LAW.own_names)
@pytest.mark.parametrize(
    ("start", "direction"),
    [
        pytest.param(start, direction, marks=[pytest.mark.long] * (turn != number % 2))
        for number, start in enumerate(STARTS)
        for turn, direction in enumerate(DIRECTIONS)
    ],
)
def test_it_converges_from_anywhere_about_a_moving_target_in_wind(name, direction, start):
    loiter, (duration, allowed) = law(name, direction), TIMES[name]
    offsets, vehicles, inputs = fly(loiter, start, duration, WIND, RUN)
    assert np.abs(range_errors(loiter, offsets)[-400:]).max() < allowed
    turn_rate_max = np.array([SMALL_UAV.turn_rate_max(v) for v in vehicles[:, 5]])
    assert np.all(np.abs(inputs[:, 0]) <= turn_rate_max)
    (x, y, _), (x_next, y_next, _) = offsets[-2:]
    assert (x * y_next - y * x_next) * loiter.sense > 0.0


@pytest.mark.parametrize("name", GUIDANCE_LAW.own_names)
@given(
    st.lists(numbers, min_size=6, max_size=6),
    st.lists(numbers, min_size=3, max_size=3),
    st.lists(numbers, min_size=3, max_size=3),
)
def test_any_finite_situation_has_finite_inputs_inside_the_limits(name, vehicle, target, drift):
    values = (np.array(v) for v in (vehicle, target, drift, drift[::-1], target[::-1]))
    with np.errstate(all="ignore"):
        inputs = law(name).inputs(Situation(*values))
    turn_rate, path_angle_rate, acceleration = inputs
    assert abs(turn_rate) <= SMALL_UAV.yaw_rate_max
    assert abs(path_angle_rate) <= SMALL_UAV.pitch_rate_max
    assert SMALL_UAV.acceleration_min <= acceleration <= SMALL_UAV.acceleration_max
