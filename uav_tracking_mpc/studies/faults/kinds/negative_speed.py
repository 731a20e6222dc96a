"""Forward speed with the wrong sign."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, ODOMETRY, Topic
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class NegativeSpeed(MessageFault):
    """Turns the sign of the forward speed, over ground or through the air."""

    name = "negative_speed"
    topics = (ODOMETRY, AIR_VELOCITY)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        twist = message.twist.twist if topic == ODOMETRY else message.twist
        twist.linear.x = -twist.linear.x
