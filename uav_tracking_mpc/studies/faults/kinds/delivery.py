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

"""Messages that are lost, late, repeated or out of their turn; what is in them stays as it is."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.autopilot import deliveries
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.stream_fault import StreamFault, TopicFault


class Loss(deliveries.Loss, StreamFault):
    """Loses one message in five, on every topic."""

    name = "loss"
    family = "network"
    share = 0.2


class Jitter(deliveries.Jitter, StreamFault):
    """Delays every message by up to 200 ms, on every topic."""

    name = "jitter"
    family = "network"


class Duplicated(deliveries.Duplicated, TopicFault):
    """Delivers a message twice at once, and a third time later."""

    name = "duplicated"


class Reordered(deliveries.Reordered, TopicFault):
    """Delays every other message behind later ones."""

    name = "reordered"
    share = 0.5


class Gap(deliveries.Silence, StreamFault):
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


class TargetLost(deliveries.Silence, StreamFault):
    """Loses every target for longer than ``target_timeout``."""

    name = "target_lost"
    family = "target"
    duration = (6.0, 9.0)
    streams = (TARGET,)


class ClockPause(deliveries.Silence, StreamFault):
    """Loses every message of /clock."""

    name = "clock_pause"
    family = "clock"
    duration = (1.0, 4.0)
    streams = (CLOCK,)
