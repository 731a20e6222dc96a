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


import copy
import dataclasses
import functools

import numpy as np
import pytest
from filled_messages import (
    altered,
    filled_air,
    filled_command,
    filled_measurement,
    filled_odometry,
    filled_point,
    over_the_wire,
)
from hypothesis import given
from hypothesis import strategies as st
from node_harness import vehicle_from_odometry

from uav_tracking_mpc.dynamics.frames import rotation_from_course
from uav_tracking_mpc.estimation.measurement import NOISE_LIMITS, SILENT, Measurement, SensorNoise
from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    plan_from_command,
    position_from_point,
    set_command,
    set_measurement,
)
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, MessageError

STATES = st.tuples(
    *[st.floats(-1e5, 1e5)] * 3, st.floats(-3.1, 3.1), st.floats(-1.4, 1.4), st.floats(0, 300)
)
INPUTS = st.tuples(*[st.floats(-5, 5)] * 3)
STAMPS = st.integers(0, 2**31 * 10**9 - 1)


@given(STATES, INPUTS, st.tuples(*[st.floats(-300, 300)] * 3), STAMPS)
def test_motion_survives_the_wire(state, rates, ground_velocity, stamp):
    received = over_the_wire(filled_odometry(stamp, state, rates, np.array(ground_velocity)))
    assert nanoseconds(received.header.stamp) == stamp
    motion = measurement_from_odometry(received)
    np.testing.assert_allclose(motion.state(state[5]), state, atol=1e-6)
    np.testing.assert_allclose(motion.ground_velocity, ground_velocity, atol=1e-9)
    assert motion.turn_rate == pytest.approx(rates[0], abs=1e-9)
    assert motion.path_angle_rate == pytest.approx(rates[1], abs=1e-9)


def test_motion_of_a_body_that_rolls():
    """Banked 30 deg in a level turn to the left: pitch and yaw rate of the body share the turn."""
    bank, turn_rate = -np.pi / 6, 0.2
    message = filled_odometry(0, [0, 0, 0, 0, 0, 20.0])
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
    state, ground = [0, 0, 0, np.pi / 2, 0, 20.0], np.array([5.0, 20.0, 1.0])
    message = filled_odometry(0, state, ground=ground)
    linear = message.twist.twist.linear
    np.testing.assert_allclose([linear.x, linear.y, linear.z], [20.0, -5.0, 1.0], atol=1e-12)


def test_air_velocity_survives_the_wire():
    message = over_the_wire(filled_air(7, 22.5))
    np.testing.assert_array_equal(air_velocity_from_twist(message), [22.5, 0.0, 0.0])


@given(st.lists(INPUTS, min_size=1, max_size=30), st.floats(0.01, 5.0), STAMPS)
def test_plan_survives_the_wire(plan, step, stamp):
    message = filled_command(stamp, np.zeros((40, 3)))  # longer, then reused
    set_command(message, stamp, np.array(plan), step)
    received, starts = plan_from_command(over_the_wire(message))
    np.testing.assert_array_equal(received, plan)
    np.testing.assert_allclose(starts, step * np.arange(len(plan)), atol=1e-9)


def test_signs_on_the_wire_are_rep_103():
    """A climb and a left turn: FLU pitch rate negative, yaw rate positive."""
    message = filled_command(0, [[0.1, 0.2, 0.3]])
    angular = message.points[0].velocities[0].angular
    assert (angular.z, angular.y) == (0.1, -0.2)
    assert message.points[0].accelerations[0].linear.x == 0.3
    odometry = filled_odometry(0, [0, 0, 0, 0, 0, 4.0], [0.1, 0.2, 0.0])
    assert odometry.twist.twist.angular.y == -0.2
    assert odometry.twist.twist.linear.x == 4.0


GOOD = {  # by topic: how a message is read, and one that can be used
    "uav/odometry": (
        vehicle_from_odometry,
        lambda: filled_odometry(0, [1.0, 2.0, 3.0, 0.4, 0.1, 5.0]),
    ),
    "uav/air_velocity": (air_velocity_from_twist, lambda: filled_air(7, 22.5)),
    "target/position": (position_from_point, lambda: filled_point(0)),
    "target/goal": (
        functools.partial(position_from_point, topic=TARGET_GOAL),
        lambda: filled_point(0),
    ),
    "uav/command": (plan_from_command, lambda: filled_command(0, np.zeros((2, 3)))),
}
NAN, INFINITE = float("nan"), float("inf")
NO_TIME = 2**32 - 1  # sent back in an answer it could lie past the last time a message can bear


@pytest.mark.parametrize(
    ("topic", "path", "value", "words"),
    [
        ("uav/odometry", "header.frame_id", "odom", "header.frame_id is 'odom', must be 'map'"),
        ("uav/odometry", "child_frame_id", "base", "child_frame_id is 'base'"),
        ("uav/odometry", "header.stamp.nanosec", 10**9, "nanosec is 1000000000, must be below"),
        ("uav/odometry", "header.stamp.nanosec", NO_TIME, "header.stamp.nanosec is 4294967295"),
        ("uav/odometry", "pose.pose.position.x", NAN, "pose.position.x is nan"),
        ("uav/odometry", "pose.pose.position.z", 1e300, "pose.position.z is 1e.300"),
        ("uav/odometry", "twist.twist.linear.y", INFINITE, "twist.linear.y is inf"),
        ("uav/odometry", "twist.twist.linear.x", 1e4, "within 1000"),
        ("uav/odometry", "twist.twist.angular.z", NAN, "twist.angular.z is nan"),
        ("uav/odometry", "twist.twist.angular.y", 1e3, "within 100"),
        ("uav/odometry", "pose.pose.orientation.w", 0.0, "pose.orientation: .* norm"),
        ("uav/odometry", "pose.pose.orientation.w", 1e308, "pose.orientation"),
        ("uav/odometry", "pose.pose.orientation.x", NAN, "pose.orientation"),
        ("uav/air_velocity", "twist.linear.z", NAN, "uav/air_velocity: twist.linear.z is nan"),
        ("uav/air_velocity", "twist.linear.z", 2e3, "within 1000"),
        ("uav/air_velocity", "header.frame_id", "map", "frame_id is 'map', must be 'base_link'"),
        ("uav/air_velocity", "header.stamp.nanosec", NO_TIME, "nanosec is 4294967295"),
        ("target/position", "point.y", NAN, "target/position: point.y is nan"),
        ("target/position", "header.frame_id", "earth", "'earth'"),
        ("target/position", "header.stamp.nanosec", NO_TIME, "nanosec is 4294967295"),
        ("target/goal", "header.frame_id", "odom", "'odom', must be 'map'"),
        ("target/goal", "point.x", INFINITE, "point.x is inf, must be finite"),
        ("target/goal", "point.y", NAN, "point.y is nan"),
        ("uav/command", "points", [], "points is empty"),
        ("uav/command", "joint_names", ["wing"], "joint_names is"),
        ("uav/command", "points.1.velocities", [], r"points\[1\] lacks"),
        ("uav/command", "header.frame_id", "", "frame_id is ''"),
        ("uav/command", "header.stamp.nanosec", NO_TIME, "nanosec is 4294967295"),
        ("uav/command", "points.0.accelerations.0.linear.x", NAN, "must be finite"),
    ],
)
def test_what_cannot_be_used_is_refused_by_field_and_value(topic, path, value, words):
    read, good = GOOD[topic]
    message = good()
    read(message)
    with pytest.raises(MessageError, match=words):
        read(altered(message, path, value))


NOISE = SensorNoise((1.0, 2.0, 5.0), (0.3, 0.3, 0.3), 0.02, 0.007)
VELOCITY = np.array([15.0, -9.0, 2.0])


def message(noise=NOISE, heading=2.0, path_angle=0.3):
    seen = Measurement(7.0, np.array([3.0, 4.0, 5.0]), VELOCITY, heading, path_angle, noise=noise)
    return over_the_wire(filled_measurement(7_000_000_000, seen))


def same(noise, other):
    for name in NOISE_LIMITS:
        np.testing.assert_allclose(getattr(noise, name), getattr(other, name), rtol=1e-9, atol=1e-9)


@given(st.floats(-3.1, 3.1), st.floats(-1.4, 1.4))
def test_what_is_told_comes_back_whatever_the_attitude(heading, path_angle):
    same(measurement_from_odometry(message(heading=heading, path_angle=path_angle)).noise, NOISE)


def test_the_covariances_are_those_of_the_errors():
    """Errors as nav_msgs has them: rotation about fixed axes, velocity in the body's."""
    heading, path_angle = 2.0, 0.3
    random, count = np.random.default_rng(0), 20_000
    truth = rotation_from_course(heading, path_angle)
    position = random.standard_normal((count, 3)) * NOISE.position
    deviations = np.array([NOISE.heading, NOISE.path_angle])
    rotations = np.array(
        [
            rotation_from_course(heading + d_psi, path_angle + d_chi)
            for d_psi, d_chi in deviations * random.standard_normal((count, 2))
        ]
    )
    error = rotations @ truth.T
    turned = 0.5 * np.column_stack(
        [
            error[:, 2, 1] - error[:, 1, 2],
            error[:, 0, 2] - error[:, 2, 0],
            error[:, 1, 0] - error[:, 0, 1],
        ]
    )
    velocity = (random.standard_normal((count, 3)) * NOISE.velocity) @ truth
    odometry = message(NOISE, heading, path_angle)
    expected = np.zeros((6, 6))
    expected[:3, :3], expected[3:, 3:] = np.cov(position.T), np.cov(turned.T)
    scale = np.concatenate([np.diag(np.cov(position.T)), np.full(3, NOISE.heading**2)])
    found = odometry.pose.covariance.reshape(6, 6)
    np.testing.assert_allclose(found, expected, atol=0.03 * np.sqrt(np.outer(scale, scale)).max())
    np.testing.assert_allclose(found[3:, 3:], expected[3:, 3:], atol=0.03 * NOISE.heading**2)
    np.testing.assert_allclose(found, found.T)
    found = odometry.twist.covariance.reshape(6, 6)
    np.testing.assert_allclose(found[:3, :3], np.cov(velocity.T), atol=0.03 * 0.09)
    np.testing.assert_array_equal(found[3:], 0.0)


def test_what_is_unknown_is_zeros_and_zeros_are_unknown():
    odometry = message(SILENT)
    assert not odometry.pose.covariance.any()
    assert not odometry.twist.covariance.any()
    assert measurement_from_odometry(odometry).noise is SILENT
    position_alone = SensorNoise(position=(1.0, 1.0, 1.0))
    same(measurement_from_odometry(message(position_alone)).noise, position_alone)


def test_a_message_is_used_again():
    odometry = message()
    seen = measurement_from_odometry(odometry)
    set_measurement(odometry, 1, dataclasses.replace(seen, noise=SILENT))
    assert measurement_from_odometry(odometry).noise is SILENT


@pytest.mark.parametrize(
    ("field", "entries", "told"),
    [
        ("pose", {0: -1.0}, {"position": (0.0,) * 3}),  # declared missing
        ("pose", {7: np.nan}, {"position": (0.0,) * 3}),
        ("pose", {14: np.inf}, {"position": (0.0,) * 3}),
        ("pose", {0: 1e12, 7: 1e12, 14: 1e12}, {"position": (0.0,) * 3}),
        ("pose", {14: 0.0}, {"position": (1.0, 2.0, np.sqrt(2.5))}),
        ("pose", {1: 1e3, 6: -7.0}, {}),  # not symmetric: what is between axes does not count
        ("pose", {35: -1e-9}, {"heading": 0.0}),
        ("pose", {35: 1e12}, {"heading": 0.0}),
        ("pose", {35: np.nan}, {"heading": 0.0}),
        ("pose", {21: np.nan}, {"path_angle": 0.0}),
        ("twist", {0: -1.0}, {"velocity": (0.0,) * 3}),
        ("twist", {1: np.nan}, {"velocity": (0.0,) * 3}),
        ("twist", {0: 1e300, 7: 1e300, 14: 1e300}, {"velocity": (0.0,) * 3}),
        ("twist", {1: 1e6}, {"velocity": (0.0,) * 3}),  # negative in some direction
    ],
)
def test_what_makes_no_sense_is_unknown_and_the_rest_counts(field, entries, told):
    odometry = message()
    covariance = getattr(odometry, field).covariance
    for index, value in entries.items():
        covariance[index] = value
    same(measurement_from_odometry(odometry).noise, dataclasses.replace(NOISE, **told))


@given(st.lists(st.floats(width=64), min_size=72, max_size=72), st.integers(0, 71))
def test_any_covariance_is_survived(entries, known):
    odometry = message()
    wild = copy.deepcopy(odometry)
    wild.pose.covariance[:], wild.twist.covariance[:] = entries[:36], entries[36:]
    seen = measurement_from_odometry(wild)
    for name, limit in NOISE_LIMITS.items():
        values = np.array(getattr(seen.noise, name))
        assert np.all((values >= 0.0) & (values <= limit))
