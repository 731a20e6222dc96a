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
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.dynamics.angles import angle_difference, wrap_angle

ANGLES = st.floats(-1e4, 1e4)


@given(ANGLES)
def test_wrapped_angle_is_the_same_direction_in_the_half_open_interval(angle):
    wrapped = float(wrap_angle(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-11)


@given(st.floats(-np.pi, np.pi, exclude_min=True))
def test_angle_inside_the_interval_comes_back_bit_for_bit(angle):
    assert float(wrap_angle(angle)) == angle


def test_half_turn_is_positive():
    assert wrap_angle([-np.pi, np.pi, 3 * np.pi]) == pytest.approx([np.pi] * 3)


def test_difference_takes_the_short_way_round():
    assert angle_difference(-3.1, 3.1) == pytest.approx(2 * np.pi - 6.2)
