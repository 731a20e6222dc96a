"""A target that leaps away and back."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.topics import TARGET, Topic
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault


class TargetTeleport(StreamFault):
    """Moves the measured target by the range of the orbit in one direction, and back at the end."""

    name = "target_teleport"
    family = "target"
    duration = (1.0, 4.0)
    streams = (TARGET,)

    def prepare(self, rng: random.Random, reach: float) -> None:
        """See :meth:`StreamFault.prepare`."""
        super().prepare(rng, reach)
        azimuth = rng.uniform(0.0, 2.0 * math.pi)
        self._leap = reach * math.cos(azimuth), reach * math.sin(azimuth)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        message = deserialize_message(data, topic.type)
        east, north = self._leap
        message.point.x += east
        message.point.y += north
        return [(0.0, serialize_message(message))]
