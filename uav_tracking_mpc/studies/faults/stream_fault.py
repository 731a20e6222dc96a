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
Beside them are the topics that they strike and the fields of the messages that they change.
"""

from __future__ import annotations

import json
import random
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.autopilot.deliveries import Delivery, StreamRule
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    CLOCK,
    COMMAND,
    ODOMETRY,
    TARGET,
    Quality,
    Topic,
)
from uav_tracking_mpc.studies.faults.kinds import Fault

if TYPE_CHECKING:
    from uav_tracking_mpc.studies.faults.node_campaign import NodeCampaign


STREAMS = (ODOMETRY, AIR_VELOCITY, TARGET, COMMAND, CLOCK)
ORDERS = Topic(
    "torture/fault",
    "std_msgs/msg/String",
    Quality(depth=100),
    "campaign",
    "A fault as JSON: reference, fault, seed, seconds, speed, reach",
)


def raw(topic: Topic) -> Topic:
    """The topic before the relay: what its sender truly sent.

    Args:
        topic: As it is after the relay.
    """
    return replace(topic, name=f"/raw{topic.name}" if topic is CLOCK else f"raw/{topic.name}")


LATEST_STAMP = 2**31 - 1  # s, where builtin_interfaces/Time ends

Field = tuple[Any, str]  # object that holds it, and its name


def shift(stamp: Any, seconds: float) -> None:
    """Move a stamp, as far as stamps go; those before 0 can be written, but not all can be read.

    Args:
        stamp: builtin_interfaces/Time, changed in place.
        seconds: By how much [s].
    """
    total = stamp.sec * 10**9 + stamp.nanosec + round(seconds * 1e9)
    total = min(max(total, -(2**31) * 10**9), LATEST_STAMP * 10**9)
    stamp.sec, stamp.nanosec = divmod(total, 10**9)


def _axes(vector: Any) -> list[Field]:
    return [(vector, axis) for axis in "xyz"]


def _odometry(message: Any) -> list[Field]:
    pose = message.pose.pose
    return [*_axes(pose.position), (pose.orientation, "w"), *_axes(message.twist.twist.linear)]


def _command(message: Any) -> list[Field]:
    return [
        field
        for point in message.points
        if point.velocities and point.accelerations  # another fault may have emptied them
        for field in (
            (point.velocities[0].angular, "y"),
            (point.velocities[0].angular, "z"),
            (point.accelerations[0].linear, "x"),
        )
    ]


# By the topic: fields of a message that hold what a controller or a vehicle computes with.
NUMBERS = {
    ODOMETRY.name: _odometry,
    AIR_VELOCITY.name: lambda message: _axes(message.twist.linear),
    TARGET.name: lambda message: _axes(message.point),
    COMMAND.name: _command,
}


FAMILIES = {  # of the faults that strike one topic alone, by its name
    ODOMETRY.name: "odometry",
    TARGET.name: "target",
    COMMAND.name: "command",
    AIR_VELOCITY.name: "air_velocity",
}


class StreamFault(StreamRule, Fault):
    """A fault that strikes messages: loses, delays, repeats or changes them.

    Attributes:
        streams: Topics that it strikes.
    """

    streams: tuple[Topic, ...] = STREAMS

    def begin(self, flight: NodeCampaign, seconds: float, seed: int) -> None:
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
        self.streams, self.family = (topic,), FAMILIES[topic.name]
        self.variant = f"{self.family}_{self.name}"

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each topic."""
        return [cls(topic) for topic in cls.topics]


class ChangeFault(StreamFault):
    """A stream fault that changes messages: all of them, or a share."""

    share = 1.0

    def deliver(self, topic: Topic, data: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamFault.deliver`."""
        if not self.strikes():
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
