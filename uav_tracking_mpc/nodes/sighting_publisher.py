"""Where the vehicle to circle was, as it said itself, on the target's topics."""

from __future__ import annotations

from rclpy.node import Node

from uav_tracking_mpc.links import Sighting
from uav_tracking_mpc.nodes.conversions import MAP, set_point, set_stamp, set_vector
from uav_tracking_mpc.nodes.topics import TARGET, TARGET_ODOMETRY


class SightingPublisher:
    """On ``target/odometry`` where the velocity is told, on ``target/position`` where it is not.

    Args:
        node: Through which it publishes.
    """

    def __init__(self, node: Node) -> None:
        self._points, self._tracks = (
            node.create_publisher(topic.type, topic.name, topic.qos)
            for topic in (TARGET, TARGET_ODOMETRY)
        )
        self._point, self._track = TARGET.type(), TARGET_ODOMETRY.type()
        self._track.header.frame_id = self._track.child_frame_id = MAP

    def publish(self, stamp: int, sighting: Sighting) -> None:
        """Publish a sighting.

        Args:
            stamp: Its time in [ns].
            sighting: Of the vehicle.
        """
        if sighting.velocity is None:
            set_point(self._point, stamp, sighting.position)
            self._points.publish(self._point)
            return
        set_stamp(self._track.header.stamp, stamp)
        set_vector(self._track.pose.pose.position, sighting.position)
        set_vector(self._track.twist.twist.linear, sighting.velocity)
        self._tracks.publish(self._track)
