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

"""Angles and rates of autopilots (North-East-Down) against rotation matrices."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from uav_tracking_mpc.dynamics.frames import (
    bank_from_turn_rate,
    course_rates_from_euler,
    heading_from_yaw,
    north_east_down,
    quaternion_from_euler,
)
from uav_tracking_mpc.dynamics.gravity import GRAVITY

ANGLES = st.floats(-3.1, 3.1)
PITCHES = st.floats(-1.3, 1.3)
RATES = st.floats(-2.0, 2.0)


def nose(roll, pitch, yaw):
    """Forward axis of the body in East, North, Up."""
    return north_east_down(Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply([1.0, 0.0, 0.0]))


@given(ANGLES, PITCHES, ANGLES)
def test_the_heading_is_where_the_nose_points(roll, pitch, yaw):
    east, north, up = nose(roll, pitch, yaw)
    heading = heading_from_yaw(yaw)
    assert math.cos(heading) * math.cos(pitch) == pytest.approx(east, abs=1e-9)
    assert math.sin(heading) * math.cos(pitch) == pytest.approx(north, abs=1e-9)
    assert up == pytest.approx(math.sin(pitch), abs=1e-9)
    assert math.remainder(heading_from_yaw(heading) - yaw, 2.0 * math.pi) == pytest.approx(0.0)


@given(ANGLES, PITCHES, ANGLES)
def test_the_quaternion_is_that_of_the_rotation(roll, pitch, yaw):
    w, x, y, z = quaternion_from_euler(roll, pitch, yaw)
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    np.testing.assert_allclose(Rotation.from_quat([x, y, z, w]).as_matrix(), expected, atol=1e-9)


@given(ANGLES, PITCHES, ANGLES, RATES, RATES, RATES)
def test_the_rates_are_those_of_the_nose(roll, pitch, yaw, p, q, r):
    step = 1e-5
    before = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    after = before * Rotation.from_rotvec(np.array([p, q, r]) * step)
    yaw_after, pitch_after, _ = after.as_euler("ZYX")
    turn, elevation = course_rates_from_euler(roll, pitch, (p, q, r))
    turned = math.remainder(yaw - yaw_after, 2.0 * math.pi) / step
    assert turn == pytest.approx(turned, abs=2e-3)
    assert elevation == pytest.approx((pitch_after - pitch) / step, abs=2e-3)


@given(st.floats(-1.2, 1.2), st.floats(5.0, 50.0))
def test_a_bank_turns_as_its_lift_does(bank, airspeed):
    """Lift that carries the weight turns the velocity by its horizontal part."""
    turn_rate = -GRAVITY * math.tan(bank) / airspeed  # right wing down turns clockwise
    assert bank_from_turn_rate(turn_rate, airspeed) == pytest.approx(bank, abs=1e-12)
