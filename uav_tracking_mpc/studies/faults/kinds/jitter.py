"""Messages of every topic late."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault

LATEST = 0.2  # s of simulated time


class Jitter(StreamFault):
    """Delays every message by up to 200 ms, on every topic."""

    name = "jitter"
    family = "network"
    duration = (2.0, 6.0)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return [(self.rng.uniform(0.0, LATEST), data)]
