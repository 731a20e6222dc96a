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

"""The target as messages: what a tracker says of it, where it truly is, and where it is sent."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.frames import course_from_quaternion, rotation_from_quaternion
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, set_stamp, set_vector
from uav_tracking_mpc.nodes.messages.message_checks import (
    FRAMES,
    POSITION_LIMIT,
    SPEED_LIMIT,
    FrameNames,
    MessageError,
    check_header,
    finite_vector,
)

if TYPE_CHECKING:
    from geometry_msgs.msg import PointStamped
    from nav_msgs.msg import Odometry

TOPIC = "target/odometry"
VARIANCE_LIMIT = 1e8  # m^2 or m^2/s^2, beyond which it says nothing
ROUNDING = 1e-9  # -, rounding: share of the greatest variance by which another may be negative


class TargetMeasurement(NamedTuple):
    """What :meth:`Controller.see_target` takes, but for the stamp.

    Attributes:
        position: In ``map``, shape (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s]; None if it is not known.
        covariance: Of position and velocity, shape (6, 6), in SI units, zeros for what is not
            known; None if neither is known.
    """

    position: NDArray[np.float64]
    velocity: NDArray[np.float64] | None
    covariance: NDArray[np.float64] | None


def target_from_odometry(message: Odometry, frames: FrameNames = FRAMES) -> TargetMeasurement:
    """Measurement of the target.

    Args:
        message: As in ``target/odometry``.
        frames: In which it must be.

    Raises:
        MessageError: Wrong frame, no time, not finite, absurd, or no unit quaternion where the
            velocity is to be rotated.
    """
    check_header(TOPIC, message.header, frames.map)
    position = finite_vector(TOPIC, "pose.position", message.pose.pose.position, POSITION_LIMIT)
    spread = _covariance(message.pose.covariance)
    velocity, velocity_spread = _velocity(message)
    if spread is None and velocity_spread is None:
        return TargetMeasurement(position, velocity, None)
    covariance = np.zeros((6, 6))
    if spread is not None:
        covariance[:3, :3] = spread
    if velocity_spread is not None:
        covariance[3:, 3:] = velocity_spread
    return TargetMeasurement(position, velocity, covariance)


def _velocity(message: Odometry) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
    """Velocity in ``map`` in [m/s] and its covariance; None for what is not known."""
    twist = message.twist
    velocity = finite_vector(TOPIC, "twist.linear", twist.twist.linear, SPEED_LIMIT)
    spread = _covariance(twist.covariance)
    if twist.covariance[0] < 0.0 or (spread is None and not velocity.any()):
        return None, None
    if message.child_frame_id in ("", message.header.frame_id):
        return velocity, spread
    q = message.pose.pose.orientation
    try:
        course_from_quaternion(q.x, q.y, q.z, q.w)
    except (ValueError, OverflowError) as error:
        raise MessageError(f"{TOPIC}: pose.orientation: {error}") from error
    rotation = rotation_from_quaternion(q.x, q.y, q.z, q.w)
    if spread is not None:
        spread = rotation @ spread @ rotation.T
    return rotation @ velocity, spread


def _covariance(entries: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """The first three rows and columns of a covariance of six; None if it says nothing."""
    matrix = np.array(entries, dtype=float).reshape(6, 6)[:3, :3]
    if not (np.isfinite(matrix).all() and matrix[0, 0] > 0.0):
        return None
    if max(matrix[0, 0], matrix[1, 1]) > VARIANCE_LIMIT:  # that of a height may be anything
        return None
    matrix = 0.5 * (matrix + matrix.T)
    variances = np.linalg.eigvalsh(matrix)
    return matrix if variances[0] >= -ROUNDING * variances[-1] else None


def set_truth(
    message: Odometry,
    stamp: int,
    position: NDArray[np.float64],
    velocity: NDArray[np.float64],
    frames: FrameNames = FRAMES,
) -> None:
    """Fill ``target/truth``.

    Args:
        message: Changed in place.
        stamp: In [ns].
        position: In ``map``, shape (3,), in [m].
        velocity: In ``map``, shape (3,), in [m/s].
        frames: Of the message.
    """
    set_stamp(message.header.stamp, stamp)
    message.header.frame_id = message.child_frame_id = frames.map
    set_vector(message.pose.pose.position, position)
    set_vector(message.twist.twist.linear, velocity)


def truth_from_odometry(message: Odometry) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """What ``target/truth`` says.

    Args:
        message: As :func:`set_truth` fills it.

    Returns:
        Stamp in [ns]; position and velocity in ``map``, shape (3,), in [m] and [m/s].
    """
    place, speed = message.pose.pose.position, message.twist.twist.linear
    position, velocity = (np.array([part.x, part.y, part.z]) for part in (place, speed))
    return nanoseconds(message.header.stamp), position, velocity


def goal_from_point(message: PointStamped, frames: FrameNames = FRAMES) -> NDArray[np.float64]:
    """Where a target is to go, shape (3,), in [m].

    Args:
        message: As in ``target/goal``; its stamp may be 0.
        frames: In which it must be.

    Raises:
        MessageError: Another frame, not finite, or absurd.
    """
    check_header("target/goal", message.header, frames.map)
    return finite_vector("target/goal", "point", message.point, POSITION_LIMIT)
