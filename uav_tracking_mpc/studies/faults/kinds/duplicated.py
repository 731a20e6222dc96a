"""Messages that come several times."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, TopicFault

LATEST = 0.3  # s of simulated time by which the third copy is late, at most


class Duplicated(TopicFault):
    """Delivers a message twice at once, and a third time later."""

    name = "duplicated"

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return [(0.0, data), (0.0, data), (self.rng.uniform(0.0, LATEST), data)]
