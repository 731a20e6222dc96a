"""Messages of every topic lost."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault

SHARE = 0.2  # of the messages


class Loss(StreamFault):
    """Loses one message in five, on every topic."""

    name = "loss"
    family = "network"
    duration = (2.0, 6.0)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return [] if self.rng.random() < SHARE else [(0.0, data)]
