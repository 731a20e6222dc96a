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

"""Stamps of the past and of the future, other frames, and a clock that jumps."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

from uav_tracking_mpc.nodes.topics import CLOCK, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.stream_fault import ChangeFault, MessageFault, shift

OFFSETS = (1.0, 3.0, 30.0, 3600.0)  # s, of a clock that jumps


class Frame(MessageFault):
    """Gives a message in another frame, or in none."""

    name = "frame"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        message.header.frame_id = self.rng.choice(("", "odom", "MAP", "map" * 1000))


class OldStamp(MessageFault):
    """Stamps a message 3 s to 20 s too early."""

    name = "old_stamp"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        shift(message.header.stamp, -self.rng.uniform(3.0, 20.0))


class FutureStamp(MessageFault):
    """Stamps a message 0.2 s to 20 s too late, or with the last time there is."""

    name = "future_stamp"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        shift(message.header.stamp, self.rng.choice((self.rng.uniform(0.2, 20.0), 1e10)))


class ClockJump(ChangeFault):
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

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        shift(message.clock, self._offset)
        if message.clock.sec < 0:  # rclpy itself ends on times before 0
            message.clock.sec = message.clock.nanosec = 0
