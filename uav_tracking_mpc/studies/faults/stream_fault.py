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

"""Bases of the faults that strike messages on their way from sender to receiver.

They act in the process of the relay (``fault_relay``), which finds the fault there by its name.
"""

from __future__ import annotations

import json
import random
from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.streams import STREAMS

if TYPE_CHECKING:
    from uav_tracking_mpc.studies.faults.injected_flight import Flight

FAMILIES = {  # of the faults that strike one topic alone, by its name
    ODOMETRY.name: "odometry",
    TARGET.name: "target",
    COMMAND.name: "command",
    AIR_VELOCITY.name: "air_velocity",
}
CHANGED_SHARE = 0.5  # of the messages: good ones in between are harder to handle

Delivery = tuple[float, bytes]  # delay in simulated time [s], serialized message


class StreamFault(Fault):
    """A fault that strikes messages: loses, delays, repeats or changes them.

    Attributes:
        streams: Topics that it strikes.
        rng: For what is random in it; set by :meth:`prepare`.
    """

    streams: tuple[Topic, ...] = STREAMS
    rng: random.Random

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`. The relay ends the fault by itself."""
        flight.order(
            json.dumps(
                {
                    "reference": self.reference,
                    "fault": self.label,
                    "seed": seed,
                    "seconds": seconds,
                    "speed": flight.speed,
                    "reach": flight.reach,
                }
            )
        )

    def prepare(self, rng: random.Random, reach: float) -> None:
        """Draw what is the same for every message while the fault lasts.

        Args:
            rng: For everything random in the fault.
            reach: Range of the orbit, as a length to go by [m].
        """
        self.rng = rng

    @abstractmethod
    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """What arrives of a message, and how much later.

        Args:
            topic: One of its streams.
            data: The message, serialized.

        Returns:
            (delay in simulated time [s], serialized message) of each that arrives.
        """


class TopicFault(StreamFault):
    """A stream fault that has a variant for each of several topics.

    Args:
        topic: That it strikes.

    Attributes:
        topics: Those that it has a variant for.
    """

    topics: ClassVar[tuple[Topic, ...]] = (ODOMETRY, TARGET, COMMAND, AIR_VELOCITY)
    duration = (1.0, 3.0)

    def __init__(self, topic: Topic) -> None:
        self.streams = (topic,)
        self.family = FAMILIES[topic.name]

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each topic."""
        return [cls(topic) for topic in cls.topics]

    @property
    def label(self) -> str:
        """Such as ``odometry_frame``."""
        return f"{self.family}_{self.name}"


class MessageFault(TopicFault):
    """A topic fault that changes every other message."""

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        if self.rng.random() > CHANGED_SHARE:
            return [(0.0, data)]
        message = deserialize_message(data, topic.type)
        self.change(topic, message)
        return [(0.0, serialize_message(message))]

    @abstractmethod
    def change(self, topic: Topic, message: Any) -> None:
        """Change a message in place.

        Args:
            topic: Of the message.
            message: As it was sent.
        """
