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

"""Where the vehicle to circle was, as it said itself, on the target's topics."""

from __future__ import annotations

from rclpy.node import Node

from uav_tracking_mpc.links import Sighting
from uav_tracking_mpc.nodes.conversions import set_point, set_stamp, set_vector
from uav_tracking_mpc.nodes.endpoints import publish
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames
from uav_tracking_mpc.nodes.topics import TARGET, TARGET_ODOMETRY


class SightingPublisher:
    """On ``target/odometry`` where the velocity is told, on ``target/position`` where it is not.

    Args:
        node: Through which it publishes.
        frames: Of the messages.
    """

    def __init__(self, node: Node, frames: FrameNames = FRAMES) -> None:
        self._frames = frames
        self._points, self._tracks = (publish(node, topic) for topic in (TARGET, TARGET_ODOMETRY))
        self._point, self._track = TARGET.type(), TARGET_ODOMETRY.type()
        self._track.header.frame_id = self._track.child_frame_id = frames.map

    def publish(self, stamp: int, sighting: Sighting) -> None:
        """Publish a sighting.

        Args:
            stamp: Its time in [ns].
            sighting: Of the vehicle.
        """
        if sighting.velocity is None:
            set_point(self._point, stamp, sighting.position, self._frames)
            self._points.publish(self._point)
            return
        set_stamp(self._track.header.stamp, stamp)
        set_vector(self._track.pose.pose.position, sighting.position)
        set_vector(self._track.twist.twist.linear, sighting.velocity)
        self._tracks.publish(self._track)
