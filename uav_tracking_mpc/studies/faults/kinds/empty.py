"""Commands without a plan."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import COMMAND, Topic
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class Empty(MessageFault):
    """Sends a command without points, or points without velocities."""

    name = "empty"
    topics = (COMMAND,)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        if self.rng.random() < 0.5:
            message.points = []
            return
        for point in message.points:
            point.velocities = []
