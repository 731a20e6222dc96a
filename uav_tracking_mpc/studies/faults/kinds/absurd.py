"""Finite values that no flight has."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.message_fields import numbers
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault

FAR = 9e6  # m; finite, within any check of plausibility that leaves room for the earth


class Absurd(MessageFault):
    """Sends a state or a target 9000 km away, or a command of 1000 rad/s."""

    name = "absurd"
    topics = (ODOMETRY, TARGET, COMMAND)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        choice = self.rng.choice
        if topic == COMMAND:
            for holder, name in numbers(topic, message):
                setattr(holder, name, choice((1e3, -1e3)))
            return
        place = message.point if topic == TARGET else message.pose.pose.position
        place.x, place.z = choice((FAR, -FAR)), choice((FAR, -FAR, 0.0))
        if topic == ODOMETRY:
            message.twist.twist.linear.x = choice((0.0, 900.0))
