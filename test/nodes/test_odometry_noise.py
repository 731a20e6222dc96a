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

"""Covariances against the statistics of what they describe, and those that describe nothing."""

import copy
import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.dynamics.frames import rotation_from_course
from uav_tracking_mpc.estimation.measurement import NOISE_LIMITS, SILENT, Measurement, SensorNoise
from uav_tracking_mpc.nodes.conversions import measurement_from_odometry, set_measurement

NOISE = SensorNoise((1.0, 2.0, 5.0), (0.3, 0.3, 0.3), 0.02, 0.007)
VELOCITY = np.array([15.0, -9.0, 2.0])


def message(noise=NOISE, heading=2.0, path_angle=0.3):
    seen = Measurement(7.0, np.array([3.0, 4.0, 5.0]), VELOCITY, heading, path_angle, noise=noise)
    odometry = Odometry()
    set_measurement(odometry, 7_000_000_000, seen)
    return deserialize_message(serialize_message(odometry), Odometry)


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
