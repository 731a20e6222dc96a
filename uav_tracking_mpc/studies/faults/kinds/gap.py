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

"""One stream silent."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.stream_fault import Delivery, StreamFault


class Gap(StreamFault):
    """Loses every message of a stream.

    Args:
        stream: What people call it.
        topics: That carry it.
    """

    name = "gap"
    family = "network"
    duration = (1.0, 1.0)

    def __init__(self, stream: str, *topics: Topic) -> None:
        self._stream, self.streams = stream, topics

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """State, target and command."""
        return [
            cls("state", ODOMETRY, AIR_VELOCITY),
            cls("target", TARGET),
            cls("command", COMMAND),
        ]

    @property
    def label(self) -> str:
        """Such as ``gap_state``."""
        return f"{self.name}_{self._stream}"

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        return []
