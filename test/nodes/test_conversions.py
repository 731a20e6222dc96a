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
from geometry_msgs.msg import PointStamped, TwistStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from trajectory_msgs.msg import MultiDOFJointTrajectory

from uav_tracking_mpc.nodes.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
    position_from_point,
    set_air_velocity,
    set_command,
    set_odometry,
    set_point,
    vehicle_from_odometry,
)
from uav_tracking_mpc.nodes.message_checks import MessageError

STATES = st.tuples(
    *[st.floats(-1e5, 1e5)] * 3, st.floats(-3.1, 3.1), st.floats(-1.4, 1.4), st.floats(0, 300)
)
INPUTS = st.tuples(*[st.floats(-5, 5)] * 3)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)


def over_the_wire(message):
    return deserialize_message(serialize_message(message), type(message))


@given(STATES, INPUTS, STAMPS)
def test_state_survives_the_wire(state, inputs, stamp):
    message = Odometry()
    set_odometry(message, stamp, np.array(state), np.array(inputs))
    received = over_the_wire(message)
    np.testing.assert_allclose(vehicle_from_odometry(received), state, atol=1e-6)
    assert nanoseconds(received.header.stamp) == stamp


@given(STATES, INPUTS, st.tuples(*[st.floats(-300, 300)] * 3))
def test_motion_survives_the_wire(state, rates, ground_velocity):
    message = Odometry()
    set_odometry(message, 0, np.array(state), np.array(rates), np.array(ground_velocity))
    motion = measurement_from_odometry(over_the_wire(message))
    np.testing.assert_allclose(motion.state(state[5]), state, atol=1e-6)
    np.testing.assert_allclose(motion.ground_velocity, ground_velocity, atol=1e-9)
    assert motion.turn_rate == pytest.approx(rates[0], abs=1e-9)
    assert motion.path_angle_rate == pytest.approx(rates[1], abs=1e-9)


def test_motion_of_a_body_that_rolls():
    """Banked 30 deg in a level turn to the left: pitch and yaw rate of the body share the turn."""
    bank, turn_rate = -np.pi / 6, 0.2
    message = Odometry()
    set_odometry(message, 0, np.array([0, 0, 0, 0, 0, 20.0]), np.zeros(3))
    message.pose.pose.orientation.x = float(np.sin(bank / 2))
    message.pose.pose.orientation.w = float(np.cos(bank / 2))
    message.twist.twist.angular.y = float(turn_rate * np.sin(bank))
    message.twist.twist.angular.z = float(turn_rate * np.cos(bank))
    message.twist.twist.linear.y = 3.0
    motion = measurement_from_odometry(message)
    assert motion.turn_rate == pytest.approx(turn_rate)
    assert motion.path_angle_rate == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(
        motion.ground_velocity, [20.0, 3.0 * np.cos(bank), 3.0 * np.sin(bank)], atol=1e-12
    )


def test_ground_velocity_is_in_body_axes_on_the_wire():
    """Heading North, drifting East: to the right, which is -y of a Forward-Left-Up body."""
    message = Odometry()
    state = np.array([0, 0, 0, np.pi / 2, 0, 20.0])
    set_odometry(message, 0, state, np.zeros(3), np.array([5.0, 20.0, 1.0]))
    linear = message.twist.twist.linear
    np.testing.assert_allclose([linear.x, linear.y, linear.z], [20.0, -5.0, 1.0], atol=1e-12)


def test_air_velocity_survives_the_wire_and_is_refused_when_bad():
    message = TwistStamped()
    set_air_velocity(message, 7, 22.5)
    np.testing.assert_array_equal(air_velocity_from_twist(over_the_wire(message)), [22.5, 0.0, 0.0])
    message.twist.linear.z = float("nan")
    with pytest.raises(MessageError, match=r"uav/air_velocity: twist.linear.z is nan"):
        air_velocity_from_twist(message)
    message.twist.linear.z = 2e3
    with pytest.raises(MessageError, match="within 1000"):
        air_velocity_from_twist(message)
    message.header.frame_id = "map"
    with pytest.raises(MessageError, match=r"header.frame_id is 'map', must be 'base_link'"):
        air_velocity_from_twist(message)


@given(st.lists(INPUTS, min_size=1, max_size=30), st.floats(0.01, 5.0), STAMPS)
def test_plan_survives_the_wire(plan, step, stamp):
    message = MultiDOFJointTrajectory()
    set_command(message, stamp, np.zeros((40, 3)), 1.0)  # longer, then reused
    set_command(message, stamp, np.array(plan), step)
    received, starts = plan_from_command(over_the_wire(message))
    np.testing.assert_array_equal(received, plan)
    np.testing.assert_allclose(starts, step * np.arange(len(plan)), atol=1e-9)


def test_signs_on_the_wire_are_rep_103():
    """A climb and a left turn: FLU pitch rate negative, yaw rate positive."""
    message = MultiDOFJointTrajectory()
    set_command(message, 0, np.array([[0.1, 0.2, 0.3]]), 1.0)
    angular = message.points[0].velocities[0].angular
    assert (angular.z, angular.y) == (0.1, -0.2)
    assert message.points[0].accelerations[0].linear.x == 0.3
    odometry = Odometry()
    set_odometry(odometry, 0, np.array([0, 0, 0, 0, 0, 4.0]), np.array([0.1, 0.2, 0.0]))
    assert odometry.twist.twist.angular.y == -0.2
    assert odometry.twist.twist.linear.x == 4.0


def good_odometry():
    message = Odometry()
    set_odometry(message, 0, np.array([1.0, 2.0, 3.0, 0.4, 0.1, 5.0]), np.zeros(3))
    return message


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("header.frame_id", "odom", "header.frame_id is 'odom', must be 'map'"),
        ("child_frame_id", "base", "child_frame_id is 'base'"),
        ("header.stamp.nanosec", 10**9, "header.stamp.nanosec is 1000000000, must be below"),
        ("pose.pose.position.x", float("nan"), "pose.position.x is nan"),
        ("pose.pose.position.z", 1e300, "pose.position.z is 1e.300"),
        ("twist.twist.linear.y", float("inf"), "twist.linear.y is inf"),
        ("twist.twist.linear.x", 1e4, "within 1000"),
        ("twist.twist.angular.z", float("nan"), "twist.angular.z is nan"),
        ("twist.twist.angular.y", 1e3, "within 100"),
        ("pose.pose.orientation.w", 0.0, "pose.orientation: .* norm"),
        ("pose.pose.orientation.w", 1e308, "pose.orientation"),
        ("pose.pose.orientation.x", float("nan"), "pose.orientation"),
    ],
)
def test_bad_odometry_is_refused_by_field_and_value(path, value, words):
    message = good_odometry()
    *parents, name = path.split(".")
    field = message
    for parent in parents:
        field = getattr(field, parent)
    setattr(field, name, value)
    with pytest.raises(MessageError, match=words):
        vehicle_from_odometry(message)


def test_bad_target_is_refused_by_field_and_value():
    message = PointStamped()
    set_point(message, 0, np.array([1.0, float("nan"), 0.0]))
    with pytest.raises(MessageError, match=r"target/position: point.y is nan"):
        position_from_point(message)
    message.header.frame_id = "earth"
    with pytest.raises(MessageError, match="'earth'"):
        position_from_point(message)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda m: m.points.clear(), "points is empty"),
        (lambda m: setattr(m, "joint_names", ["wing"]), "joint_names is"),
        (lambda m: setattr(m.points[1], "velocities", []), r"points\[1\] lacks"),
        (lambda m: setattr(m.header, "frame_id", ""), "frame_id is ''"),
        (
            lambda m: setattr(m.points[0].accelerations[0].linear, "x", float("nan")),
            "must be finite",
        ),
    ],
)
def test_bad_command_is_refused_with_the_reason(change, words):
    message = MultiDOFJointTrajectory()
    set_command(message, 0, np.zeros((2, 3)), 1.0)
    change(message)
    with pytest.raises(MessageError, match=words):
        plan_from_command(message)


@pytest.mark.parametrize(
    ("read", "message"),
    [
        (measurement_from_odometry, Odometry()),
        (air_velocity_from_twist, TwistStamped()),
        (position_from_point, PointStamped()),
        (plan_from_command, MultiDOFJointTrajectory()),
    ],
)
def test_a_stamp_that_is_no_time_is_refused(read, message):
    """Sent back in an answer it could lie past the last time that a message can bear."""
    message.header.frame_id = "base_link" if read is air_velocity_from_twist else "map"
    message.header.stamp.sec, message.header.stamp.nanosec = 2**31 - 1, 2**32 - 1
    with pytest.raises(MessageError, match="header.stamp.nanosec is 4294967295"):
        read(message)
