"""Messages that lose their turn."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, TopicFault

SHARE = 0.5  # of the messages
DELAY = 0.3  # s of simulated time


class Reordered(TopicFault):
    """Delays every other message behind later ones."""

    name = "reordered"

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return [(DELAY if self.rng.random() < SHARE else 0.0, data)]
