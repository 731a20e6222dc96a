"""Stamps of the past."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.message_fields import shift
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class OldStamp(MessageFault):
    """Stamps a message 3 s to 20 s too early."""

    name = "old_stamp"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        shift(message.header.stamp, -self.rng.uniform(3.0, 20.0))
