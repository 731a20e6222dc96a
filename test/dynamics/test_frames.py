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
from scipy.spatial.transform import Rotation

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import (
    bank_from_turn_rate,
    body_rates,
    course_from_quaternion,
    course_rates,
    course_rates_from_euler,
    heading_from_yaw,
    pitch_rate_from_path_angle_rate,
    quaternion_from_course,
    quaternion_from_euler,
    rotation_from_course,
    rotation_from_quaternion,
    wrap_angle,
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


@given(HEADINGS, PATH_ANGLES, st.floats(-3.1, 3.1), st.sampled_from([1.0, 0.9995]))
def test_rotation_of_a_quaternion_is_scipys(heading, path_angle, roll, norm):
    rotation = Rotation.from_euler("ZYX", [heading, -path_angle, roll])
    ours = rotation_from_quaternion(*(norm * rotation.as_quat()))
    np.testing.assert_allclose(ours, rotation.as_matrix(), atol=1e-14)


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


def test_a_nose_straight_up_has_no_course_rates_and_pitch_is_positive_down():
    assert course_rates(rotation_from_course(0.3, np.pi / 2), (0.1, 0.2, 0.3)) == (0.0, 0.0)
    assert pitch_rate_from_path_angle_rate(0.3) == -0.3  # FLU: positive nose down


@given(st.floats(-1e4, 1e4) | st.just(-np.pi) | st.just(3 * np.pi))
def test_wrapped_angle_is_the_same_direction_in_the_half_open_interval(angle):
    wrapped = float(wrap_angle(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-11)
    assert float(wrap_angle(wrapped)) == wrapped  # bit for bit


ANGLES_AUTOPILOT_FRAMES = st.floats(-3.1, 3.1)
PITCHES = st.floats(-1.3, 1.3)
RATES = st.floats(-2.0, 2.0)


def nose(roll, pitch, yaw):
    """Forward axis of the body in East, North, Up."""
    north, east, down = Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply([1.0, 0.0, 0.0])
    return east, north, -down


@given(ANGLES_AUTOPILOT_FRAMES, PITCHES, ANGLES_AUTOPILOT_FRAMES)
def test_the_heading_is_where_the_nose_points(roll, pitch, yaw):
    east, north, up = nose(roll, pitch, yaw)
    heading = heading_from_yaw(yaw)
    assert math.cos(heading) * math.cos(pitch) == pytest.approx(east, abs=1e-9)
    assert math.sin(heading) * math.cos(pitch) == pytest.approx(north, abs=1e-9)
    assert up == pytest.approx(math.sin(pitch), abs=1e-9)
    assert math.remainder(heading_from_yaw(heading) - yaw, 2.0 * math.pi) == pytest.approx(0.0)


@given(ANGLES_AUTOPILOT_FRAMES, PITCHES, ANGLES_AUTOPILOT_FRAMES)
def test_the_quaternion_is_that_of_the_rotation(roll, pitch, yaw):
    w, x, y, z = quaternion_from_euler(roll, pitch, yaw)
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    np.testing.assert_allclose(Rotation.from_quat([x, y, z, w]).as_matrix(), expected, atol=1e-9)


@given(ANGLES_AUTOPILOT_FRAMES, PITCHES, ANGLES_AUTOPILOT_FRAMES, RATES, RATES, RATES)
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
