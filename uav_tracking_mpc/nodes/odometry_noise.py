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

"""Noise of a measurement as the covariances of an Odometry message, and back.

As nav_msgs defines it, that of the pose is about the axes of ``map``, in the order x, y, z and
rotations about x, y, z; that of the twist is about those of ``base_link``. A heading turns about
the axis up. A path angle turns about the horizontal axis to the left of the heading, so its
variance spreads over the rotations about x and y. There is no roll to be wrong about.

A covariance of zeros is unknown, by ROS convention, and so is each of its parts that makes no sense
(:mod:`~uav_tracking_mpc.estimation.told_noise`). What it says between axes counts for the velocity
alone, which is turned to ``map``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import SILENT, SensorNoise
from uav_tracking_mpc.estimation.told_noise import UNKNOWN, axes_noise, makes_sense, scalar_noise

if TYPE_CHECKING:
    from nav_msgs.msg import Odometry

VARIANCES = slice(0, 15, 7)  # of x, y, z among the 36 entries
BLOCK = (slice(0, 3), slice(6, 9), slice(12, 15))  # rows of x, y, z among them
HEADING = 35  # rotation about the axis up
TILT = (21, 22, 27, 28)  # rotations about x and y


def set_noise(message: Odometry, noise: SensorNoise, rotation: NDArray[np.float64]) -> None:
    """Fill the covariances of an Odometry message.

    Args:
        message: Changed in place.
        noise: Of the measurement; an unknown part gets zeros.
        rotation: From ``base_link`` to ``map`` at the measurement, shape (3, 3).
    """
    pose, twist = message.pose.covariance, message.twist.covariance
    if noise is SILENT:
        pose[:], twist[:] = 0.0, 0.0
        return
    pose[VARIANCES] = np.square(noise.position)
    left, variance = rotation[:2, 1], noise.path_angle**2
    pose[list(TILT)] = variance * np.outer(left, left).ravel()
    pose[HEADING] = noise.heading**2
    block = (rotation.T * np.square(noise.velocity)) @ rotation
    for row, values in zip(BLOCK, block, strict=True):
        twist[row] = values


def noise_from_odometry(message: Odometry, rotation: NDArray[np.float64]) -> SensorNoise:
    """Noise as the covariances of an Odometry message tell it; what makes no sense is unknown.

    Args:
        message: As in ``uav/odometry``.
        rotation: From ``base_link`` to ``map`` at the measurement, shape (3, 3).
    """
    # Floats, not arrays: so few numbers are faster by themselves, and this is the hot path.
    pose, twist = message.pose.covariance.tolist(), message.twist.covariance.tolist()
    if not (any(pose) or any(twist)):
        return SILENT
    axes = rotation.tolist()
    (east, _, _), (north, _, _), _ = axes
    tilts = [pose[index] for index in TILT]
    velocity = UNKNOWN
    if makes_sense(twist[VARIANCES]):
        block = [twist[row] for row in BLOCK]
        velocity = axes_noise("velocity", [_quadratic(block, axis) for axis in axes])
    told = SensorNoise(
        axes_noise("position", pose[VARIANCES]),
        velocity,
        scalar_noise("heading", pose[HEADING]),
        scalar_noise("path_angle", _along(tilts, -north, east)),
    )
    return SILENT if told == SILENT else told


def _quadratic(matrix: list[list[float]], axis: list[float]) -> float:
    """Variance along an axis of a covariance, both of three."""
    x, y, z = axis
    return sum(a * (b * x + c * y + d * z) for a, (b, c, d) in zip(axis, matrix, strict=True))


def _along(tilts: list[float], x: float, y: float) -> float:
    """Variance of the rotation about a horizontal axis (x, y) of any length."""
    xx, xy, yx, yy = tilts
    squared = x * x + y * y
    return (x * x * xx + x * y * (xy + yx) + y * y * yy) / squared if squared > 0.0 else 0.0
