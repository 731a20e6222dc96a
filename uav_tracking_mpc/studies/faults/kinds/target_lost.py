"""No target for longer than the controller's patience."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import TARGET, Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault


class TargetLost(StreamFault):
    """Loses every target for longer than ``target_timeout``."""

    name = "target_lost"
    family = "target"
    duration = (6.0, 9.0)
    streams = (TARGET,)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return []
