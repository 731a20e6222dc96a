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

"""Where a simulated target truly is, and where it is sent, as messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.nodes.conversions import nanoseconds, set_stamp, set_vector
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames
from uav_tracking_mpc.nodes.message_checks import POSITION_LIMIT, check_header, finite_vector

if TYPE_CHECKING:
    from geometry_msgs.msg import PointStamped
    from nav_msgs.msg import Odometry


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
