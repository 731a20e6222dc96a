"""An attitude that is none."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import ODOMETRY, Topic
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class Quaternion(MessageFault):
    """Sends the quaternion (0, 0, 0, 0)."""

    name = "quaternion"
    topics = (ODOMETRY,)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        q = message.pose.pose.orientation
        q.x = q.y = q.z = q.w = 0.0
