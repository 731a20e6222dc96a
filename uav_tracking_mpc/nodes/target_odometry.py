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

"""What a tracker says of the target in ``target/odometry``: position, velocity, covariance.

As nav_msgs defines it, the pose is in ``header.frame_id`` and the twist in ``child_frame_id``. The
pose must be in ``map``. Where ``child_frame_id`` is empty or that same frame the velocity is taken
as one in ``map``; otherwise it is in the target's own frame and is rotated by the pose's
orientation.

A covariance counts from its position or velocity entries (x, y, z). By ROS convention one whose
first entry is not positive is unknown, and so is one that is not finite, has a negative variance in
some direction, or so large a horizontal one that it says nothing. A velocity is left out if its
covariance is declared missing (a negative first entry), or if it is zero and has no covariance,
which is what a tracker sends that knows none.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.frames import course_from_quaternion, rotation_from_quaternion
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames
from uav_tracking_mpc.nodes.message_checks import (
    POSITION_LIMIT,
    SPEED_LIMIT,
    MessageError,
    check_header,
    finite_vector,
)

if TYPE_CHECKING:
    from nav_msgs.msg import Odometry

TOPIC = "target/odometry"
VARIANCE_LIMIT = 1e8  # m^2 or m^2/s^2, beyond which it says nothing
ROUNDING = 1e-9  # of the greatest variance, by which another may be negative


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
