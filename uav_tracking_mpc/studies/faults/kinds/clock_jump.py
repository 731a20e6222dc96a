# Copyright 2026 uav_tracking_mpc maintainers
#
# Licensed under the Apache License, Version 2.0 (the "License");
# you may not use this file except in compliance with the License.
# You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software
# distributed under the License is distributed on an "AS IS" BASIS,
# WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
# See the License for the specific language governing permissions and
# limitations under the License.

"""A clock that is ahead or behind."""

from __future__ import annotations

import random
from collections.abc import Sequence

from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.topics import CLOCK, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.message_fields import shift
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault

OFFSETS = (1.0, 3.0, 30.0, 3600.0)  # s


class ClockJump(StreamFault):
    """Moves /clock by 1 s to 1 h, and back at the end.

    Args:
        direction: "forward" or "backward".
    """

    name = "clock_jump"
    family = "clock"
    duration = (1.0, 4.0)
    streams = (CLOCK,)

    def __init__(self, direction: str) -> None:
        self._direction = direction

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each direction."""
        return [cls("forward"), cls("backward")]

    @property
    def label(self) -> str:
        """Such as ``clock_forward``."""
        return f"{self.family}_{self._direction}"

    def prepare(self, rng: random.Random, reach: float) -> None:
        """See :meth:`StreamFault.prepare`."""
        super().prepare(rng, reach)
        self._offset = rng.choice(OFFSETS) * (1.0 if self._direction == "forward" else -1.0)

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        message = deserialize_message(data, topic.type)
        shift(message.clock, self._offset)
        if message.clock.sec < 0:  # rclpy itself ends on times before 0
            message.clock.sec = message.clock.nanosec = 0
        return [(0.0, serialize_message(message))]
