"""A clock that stands still."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import CLOCK, Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault


class ClockPause(StreamFault):
    """Loses every message of /clock."""

    name = "clock_pause"
    family = "clock"
    duration = (1.0, 4.0)
    streams = (CLOCK,)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return []
