import numpy as np
import pytest
from geometry_msgs.msg import PointStamped
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message
from trajectory_msgs.msg import MultiDOFJointTrajectory

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    markers_message,
    nanoseconds,
    path_message,
    plan_from_command,
    position_from_point,
    set_command,
    set_odometry,
    set_point,
    vehicle_from_odometry,
)

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
        ("pose.pose.position.x", float("nan"), "pose.position.x is nan"),
        ("pose.pose.position.z", 1e300, "pose.position.z is 1e.300"),
        ("twist.twist.linear.y", float("inf"), "twist.linear.y is inf"),
        ("twist.twist.linear.x", 1e4, "within 1000"),
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


def test_what_viewers_get_can_be_serialized():
    states = np.column_stack([np.arange(5.0)] * 6)
    path = over_the_wire(path_message(1, states))
    assert [pose.pose.position.x for pose in path.poses] == [0.0, 1.0, 2.0, 3.0, 4.0]
    markers = over_the_wire(markers_message(1, states, np.zeros(3), Orbit(150.0, 50.0, 4.0)))
    circle = markers.markers[1].points
    assert np.hypot(circle[9].x, circle[9].y) == pytest.approx(np.sqrt(20000.0))
    assert len({marker.id for marker in markers.markers}) == 4
