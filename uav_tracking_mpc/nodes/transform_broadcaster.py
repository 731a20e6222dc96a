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

"""``/tf`` and ``/tf_static`` from who publishes the aircraft's state, where ROS has tf2_msgs.

Static are the frames of autopilots, as MAVROS names them: ``map_ned`` and ``base_link_frd``, the
same places with north, east, down and forward, right, down as axes. The target is a point without
orientation and has no frame. Where ``map`` lies on earth is for others to say.
"""

from __future__ import annotations

import importlib
from typing import Any

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.dynamics.frames import FORWARD_RIGHT_DOWN, NORTH_EAST_DOWN
from uav_tracking_mpc.nodes.conversions import set_stamp
from uav_tracking_mpc.nodes.endpoints import publish
from uav_tracking_mpc.nodes.frame_names import FrameNames
from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.nodes.vehicle_transform import vehicle_transform

# As tf2 has them.
MOVING = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
STATIC = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


class TransformBroadcaster:
    """Transform from ``map`` to the aircraft with each of its states.

    Args:
        node: Through which it publishes.
        frames: Of the aircraft's state.
    """

    def __init__(self, node: Node, frames: FrameNames) -> None:
        self._publisher: Any = None
        try:
            kind: Any = importlib.import_module("tf2_msgs.msg").TFMessage
        except ImportError:
            node.get_logger().info("tf2_msgs is not installed: /tf is not published")
            return
        self._moving = kind(transforms=[TransformStamped()])
        self._publisher = publish(node, _topic("/tf", kind, MOVING))
        self._static = publish(node, _topic("/tf_static", kind, STATIC))
        stamp = node.get_clock().now().nanoseconds
        self._static.publish(kind(transforms=static_transforms(stamp, frames)))

    def publish(self, odometry: Odometry) -> None:
        """Publish the transform that a state says, if somebody listens.

        Args:
            odometry: As in ``uav/odometry``.
        """
        if self._publisher is not None and self._publisher.get_subscription_count():
            vehicle_transform(odometry, self._moving.transforms[0])
            self._publisher.publish(self._moving)


def static_transforms(stamp: int, frames: FrameNames) -> list[TransformStamped]:
    """From each frame to the one with an autopilot's axes.

    Args:
        stamp: In [ns].
        frames: Of the aircraft's state.
    """
    transforms = []
    for parent, ending, rotation in (
        (frames.map, "_ned", NORTH_EAST_DOWN),
        (frames.base, "_frd", FORWARD_RIGHT_DOWN),
    ):
        message = TransformStamped()
        set_stamp(message.header.stamp, stamp)
        message.header.frame_id, message.child_frame_id = parent, parent + ending
        q = message.transform.rotation
        q.x, q.y, q.z, q.w = rotation
        transforms.append(message)
    return transforms


def _topic(name: str, kind: type, qos: QoSProfile) -> Topic:
    return Topic(name, kind, qos, "uav_simulator or autopilot_link", "Frames for tf2.")
