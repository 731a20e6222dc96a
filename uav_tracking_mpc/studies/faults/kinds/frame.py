"""Another frame."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class Frame(MessageFault):
    """Gives a message in another frame, or in none."""

    name = "frame"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        message.header.frame_id = self.rng.choice(("", "odom", "MAP", "map" * 1000))
