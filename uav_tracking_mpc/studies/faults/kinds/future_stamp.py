"""Stamps of the future."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.message_fields import shift
from uav_tracking_mpc.studies.faults.stream_fault import MessageFault


class FutureStamp(MessageFault):
    """Stamps a message 0.2 s to 20 s too late, or with the last time there is."""

    name = "future_stamp"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`MessageFault.change`."""
        shift(message.header.stamp, self.rng.choice((self.rng.uniform(0.2, 20.0), 1e10)))
