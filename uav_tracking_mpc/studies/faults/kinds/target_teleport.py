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
