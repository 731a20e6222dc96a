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
from scipy.spatial.transform import Rotation

from uav_tracking_mpc.dynamics.frames import (
    body_rates,
    course_from_quaternion,
    course_rates,
    pitch_rate_from_path_angle_rate,
    quaternion_from_course,
    rotation_from_course,
    rotation_from_quaternion,
)

HEADINGS = st.floats(-np.pi, np.pi)
PATH_ANGLES = st.floats(-1.5, 1.5)


@given(HEADINGS, PATH_ANGLES)
def test_attitude_is_heading_about_up_then_pitch_up_about_left(heading, path_angle):
    expected = Rotation.from_euler("ZY", [heading, -path_angle])
    quaternion = Rotation.from_quat(quaternion_from_course(heading, path_angle))
    np.testing.assert_allclose(quaternion.as_matrix(), expected.as_matrix(), atol=1e-14)
    np.testing.assert_allclose(
        rotation_from_course(heading, path_angle), expected.as_matrix(), atol=1e-14
    )


@given(HEADINGS, PATH_ANGLES)
def test_course_survives_the_quaternion(heading, path_angle):
    back = course_from_quaternion(*quaternion_from_course(heading, path_angle))
    assert np.exp(1j * back[0]) == pytest.approx(np.exp(1j * heading), abs=1e-12)
    assert back[1] == pytest.approx(path_angle, abs=1e-7)


def test_roll_does_not_change_the_course():
    rolled = Rotation.from_euler("ZYX", [0.7, -0.2, 0.9]).as_quat()
    assert course_from_quaternion(*rolled) == pytest.approx((0.7, 0.2))


@pytest.mark.parametrize(
    "quaternion", [(0, 0, 0, 0), (0, 0, 0, 2), (np.nan, 0, 0, 1), (np.inf, 0, 0, 1)]
)
def test_what_is_no_unit_quaternion_is_refused(quaternion):
    with pytest.raises(ValueError, match="norm"):
        course_from_quaternion(*quaternion)


@given(HEADINGS, PATH_ANGLES, st.floats(-1, 1), st.floats(-1, 1))
def test_body_rates_turn_the_attitude(heading, path_angle, turn_rate, path_angle_rate):
    dt = 1e-6
    before = rotation_from_course(heading, path_angle)
    after = rotation_from_course(heading + turn_rate * dt, path_angle + path_angle_rate * dt)
    rates = Rotation.from_matrix(before.T @ after).as_rotvec() / dt
    expected = body_rates(path_angle, (turn_rate, path_angle_rate, 0.0))
    np.testing.assert_allclose(rates, expected, atol=1e-5)


@given(HEADINGS, PATH_ANGLES, st.floats(-3.1, 3.1))
def test_rotation_of_a_quaternion_is_scipys(heading, path_angle, roll):
    rotation = Rotation.from_euler("ZYX", [heading, -path_angle, roll])
    np.testing.assert_allclose(
        rotation_from_quaternion(*rotation.as_quat()), rotation.as_matrix(), atol=1e-14
    )
    np.testing.assert_allclose(
        rotation_from_quaternion(*(0.9995 * rotation.as_quat())), rotation.as_matrix(), atol=1e-14
    )


@given(HEADINGS, st.floats(-1.4, 1.4), st.floats(-3.1, 3.1), st.tuples(*[st.floats(-1, 1)] * 3))
def test_course_rates_are_those_of_the_forward_axis(heading, path_angle, roll, angular):
    """Against a small rotation of any attitude, rolled or not."""
    dt = 1e-6
    before = Rotation.from_euler("ZYX", [heading, -path_angle, roll])
    after = before * Rotation.from_rotvec(dt * np.array(angular))
    turn_rate, path_angle_rate = course_rates(before.as_matrix(), angular)
    e, following = before.as_matrix()[:, 0], after.as_matrix()[:, 0]
    turned = np.arctan2(e[0] * following[1] - e[1] * following[0], e[:2] @ following[:2])
    assert turn_rate == pytest.approx(turned / dt, abs=1e-3)
    climbed = np.arcsin(following[2]) - np.arcsin(e[2])
    assert path_angle_rate == pytest.approx(climbed / dt, abs=1e-3)


@given(HEADINGS, PATH_ANGLES, st.floats(-1, 1), st.floats(-1, 1))
def test_course_rates_undo_body_rates(heading, path_angle, turn_rate, path_angle_rate):
    rates = body_rates(path_angle, (turn_rate, path_angle_rate, 0.0))
    back = course_rates(rotation_from_course(heading, path_angle), rates)
    assert back == pytest.approx((turn_rate, path_angle_rate), abs=1e-12)


def test_a_nose_straight_up_has_no_course_rates():
    assert course_rates(rotation_from_course(0.3, np.pi / 2), (0.1, 0.2, 0.3)) == (0.0, 0.0)


def test_flu_pitch_rate_is_positive_nose_down():
    assert pitch_rate_from_path_angle_rate(0.3) == -0.3
