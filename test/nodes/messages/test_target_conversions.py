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
from filled_messages import altered, filled_point
from nav_msgs.msg import Odometry

from uav_tracking_mpc.nodes.messages.conversions import (
    position_from_point,
    set_orientation,
    set_truth,
    set_vector,
    target_from_odometry,
    truth_from_odometry,
)
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, TARGET_TRUTH, MessageError


def message(position=(1.0, 2.0, 3.0), velocity=(5.0, 0.0, 0.0), child="", heading=0.0):
    odometry = Odometry()
    odometry.header.frame_id, odometry.child_frame_id = "map", child
    set_vector(odometry.pose.pose.position, position)
    set_orientation(odometry.pose.pose.orientation, heading, 0.0)
    set_vector(odometry.twist.twist.linear, velocity)
    return odometry


def covariance(x, y, z=1.0, xy=0.0):
    matrix = np.diag([x, y, z, 7.0, 7.0, 7.0])
    matrix[0, 1] = matrix[1, 0] = xy
    return matrix.ravel()


@pytest.mark.parametrize("child", ["", "map"])
def test_a_velocity_in_map_is_taken_as_it_is(child):
    position, velocity, known = target_from_odometry(message(child=child, heading=1.0))
    np.testing.assert_array_equal(position, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(velocity, [5.0, 0.0, 0.0])
    assert known is None


def test_a_velocity_in_the_targets_frame_is_rotated_with_its_covariance():
    odometry = message(child="car", heading=math.pi / 2.0)
    odometry.twist.covariance = covariance(4.0, 0.25)
    odometry.pose.covariance = covariance(9.0, 1.0, xy=0.5)
    _, velocity, known = target_from_odometry(odometry)
    np.testing.assert_allclose(velocity, [0.0, 5.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(known[3:, 3:], np.diag([0.25, 4.0, 1.0]), atol=1e-12)
    np.testing.assert_array_equal(known[:2, :2], [[9.0, 0.5], [0.5, 1.0]])
    np.testing.assert_array_equal(known[:3, 3:], 0.0)


@pytest.mark.parametrize(
    "entries",
    [
        np.zeros(36),
        covariance(-1.0, 1.0),
        covariance(math.nan, 1.0),
        covariance(math.inf, 1.0),
        covariance(1.0, -1.0),
        covariance(1.0, 1.0, xy=2.0),
        covariance(1e12, 1e12),
    ],
)
def test_what_is_no_covariance_is_unknown(entries):
    odometry = message()
    odometry.pose.covariance = entries
    assert target_from_odometry(odometry).covariance is None
    odometry.twist.covariance = covariance(0.04, 0.04)
    known = target_from_odometry(odometry).covariance
    assert not known[:3, :3].any() and known[3, 3] == 0.04


def test_the_height_of_a_planar_tracker_may_be_anything():
    odometry = message()
    odometry.pose.covariance = covariance(4.0, 4.0, z=1e12)
    assert target_from_odometry(odometry).covariance[0, 0] == 4.0


def test_a_velocity_that_is_not_measured_is_left_out():
    odometry = message()
    odometry.twist.covariance = covariance(-1.0, 0.0)
    assert target_from_odometry(odometry).velocity is None
    assert target_from_odometry(message(velocity=(0.0, 0.0, 0.0))).velocity is None
    standing = message(velocity=(0.0, 0.0, 0.0))
    standing.twist.covariance = covariance(0.01, 0.01)
    np.testing.assert_array_equal(target_from_odometry(standing).velocity, 0.0)


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("header.frame_id", "odom", "header.frame_id is 'odom'"),
        ("header.stamp.nanosec", 2**32 - 1, "header.stamp.nanosec is 4294967295"),
        ("pose.pose.position.y", math.nan, "pose.position.y is nan"),
        ("twist.twist.linear.z", 1e9, "twist.linear.z is"),
        ("pose.pose.orientation.w", 0.0, "pose.orientation: quaternion"),
    ],
)
def test_bad_messages_are_refused_by_field_and_value(path, value, words):
    with pytest.raises(MessageError, match=f"target/odometry: {words}"):
        target_from_odometry(altered(message(child="car"), path, value))


def test_no_orientation_is_needed_in_map():
    odometry = message()
    odometry.pose.pose.orientation.w = 0.0
    assert target_from_odometry(odometry).velocity is not None


POSITION, VELOCITY = np.array([1.0, -2.0, 3.5]), np.array([0.5, 4.0, -0.25])


def test_the_truth_there_and_back():
    message = TARGET_TRUTH.type()
    set_truth(message, 1_700_000_000_123_456_789, POSITION, VELOCITY)
    stamp, position, velocity = truth_from_odometry(message)
    assert stamp == 1_700_000_000_123_456_789
    np.testing.assert_array_equal([position, velocity], [POSITION, VELOCITY])
    # It is an odometry like that of a tracker.
    np.testing.assert_array_equal(target_from_odometry(message).velocity, VELOCITY)


def test_a_goal_needs_no_stamp():
    goal = position_from_point(filled_point(0, POSITION), topic=TARGET_GOAL)
    np.testing.assert_array_equal(goal, POSITION)
