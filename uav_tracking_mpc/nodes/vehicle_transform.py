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

"""The transform from ``map`` to the aircraft that an Odometry message says, for ``/tf``."""

from __future__ import annotations

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry


def vehicle_transform(
    odometry: Odometry, message: TransformStamped | None = None
) -> TransformStamped:
    """Transform of the aircraft's frame, as tf2 has it: pose of the child in the parent.

    Parent and child are the frames of the odometry, which bear the prefix of their aircraft.

    Args:
        odometry: As in ``uav/odometry``.
        message: To be changed in place; None for a new one. Stamp and orientation are those of
            the odometry itself, not copies.
    """
    if message is None:
        message = TransformStamped()
    message.header = odometry.header
    message.child_frame_id = odometry.child_frame_id
    position, translation = odometry.pose.pose.position, message.transform.translation
    translation.x, translation.y, translation.z = position.x, position.y, position.z
    message.transform.rotation = odometry.pose.pose.orientation
    return message
