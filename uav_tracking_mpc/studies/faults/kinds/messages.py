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

"""Faults of messages: lost, late, repeated, out of turn; with other stamps, frames or numbers."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from uav_tracking_mpc.autopilot import deliveries
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.stream_fault import (
    FAMILIES,
    NUMBERS,
    ChangeFault,
    StreamFault,
    TopicFault,
    shift,
)


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


# Family, duration in [s] and topics of each; a target is lost for longer than ``target_timeout``.
SILENCES: dict[str, tuple[str, tuple[float, float], tuple[Topic, ...]]] = {
    "gap_state": ("network", (1.0, 1.0), (ODOMETRY, AIR_VELOCITY)),
    "gap_target": ("network", (1.0, 1.0), (TARGET,)),
    "gap_command": ("network", (1.0, 1.0), (COMMAND,)),
    "target_lost": ("target", (6.0, 9.0), (TARGET,)),
    "clock_pause": ("clock", (1.0, 4.0), (CLOCK,)),
}


class Silence(deliveries.Silence, StreamFault):
    """Loses every message of some topics.

    Args:
        variant: One of :data:`SILENCES`.
    """

    name = "silence"

    def __init__(self, variant: str) -> None:
        self.variant = variant
        self.family, self.duration, self.streams = SILENCES[variant]

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """All of them."""
        return [cls(variant) for variant in SILENCES]


OFFSETS = (1.0, 3.0, 30.0, 3600.0)  # s, of a clock that jumps


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
        self._sign, self.variant = 1.0 if direction == "forward" else -1.0, f"clock_{direction}"

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each direction."""
        return [cls("forward"), cls("backward")]

    def prepare(self, rng: random.Random, reach: float) -> None:
        """See :meth:`StreamFault.prepare`."""
        super().prepare(rng, reach)
        self._offset = rng.choice(OFFSETS) * self._sign

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        shift(message.clock, self._offset)
        if message.clock.sec < 0:  # rclpy itself ends on times before 0
            message.clock.sec = message.clock.nanosec = 0


class TargetTeleport(ChangeFault):
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

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        east, north = self._leap
        message.point.x += east
        message.point.y += north


FAR = 9e6  # m; finite, within any check of plausibility that leaves room for the earth


def bad_number(value: float, topic: Topic, message: Any, rng: random.Random) -> None:
    """Replace one number by this one, of either sign."""
    fields = NUMBERS[topic.name](message)
    if fields:
        holder, name = rng.choice(fields)
        setattr(holder, name, rng.choice((1.0, -1.0)) * value)


def frame(topic: Topic, message: Any, rng: random.Random) -> None:
    """Give it in another frame, or in none."""
    message.header.frame_id = rng.choice(("", "odom", "MAP", "map" * 1000))


def old_stamp(topic: Topic, message: Any, rng: random.Random) -> None:
    """Stamp it 3 s to 20 s too early."""
    shift(message.header.stamp, -rng.uniform(3.0, 20.0))


def future_stamp(topic: Topic, message: Any, rng: random.Random) -> None:
    """Stamp it 0.2 s to 20 s too late, or with the last time there is."""
    shift(message.header.stamp, rng.choice((rng.uniform(0.2, 20.0), 1e10)))


def quaternion(topic: Topic, message: Any, rng: random.Random) -> None:
    """Make the quaternion (0, 0, 0, 0)."""
    q = message.pose.pose.orientation
    q.x = q.y = q.z = q.w = 0.0


def negative_speed(topic: Topic, message: Any, rng: random.Random) -> None:
    """Turn the sign of the forward speed, over ground or through the air."""
    twist = message.twist.twist if topic == ODOMETRY else message.twist
    twist.linear.x = -twist.linear.x


def absurd(topic: Topic, message: Any, rng: random.Random) -> None:
    """Put a state or a target 9000 km away, or command 1000 rad/s."""
    if topic == COMMAND:
        for holder, name in NUMBERS[topic.name](message):
            setattr(holder, name, rng.choice((1e3, -1e3)))
        return
    place = message.point if topic == TARGET else message.pose.pose.position
    place.x, place.z = rng.choice((FAR, -FAR)), rng.choice((FAR, -FAR, 0.0))
    if topic == ODOMETRY:
        message.twist.twist.linear.x = rng.choice((0.0, 900.0))


def empty(topic: Topic, message: Any, rng: random.Random) -> None:
    """Leave a command without points, or its points without velocities."""
    kept = rng.choice((0, len(message.points)))
    message.points = message.points[:kept]
    for point in message.points:
        point.velocities = []


EVERY = TopicFault.topics
# What is done to a message, and on which topics.
CHANGES: dict[str, tuple[Callable[[Topic, Any, random.Random], None], tuple[Topic, ...]]] = {
    "nan": (partial(bad_number, math.nan), EVERY),
    "inf": (partial(bad_number, math.inf), EVERY),
    "huge": (partial(bad_number, 1e300), EVERY),
    "frame": (frame, EVERY),
    "old_stamp": (old_stamp, EVERY),
    "future_stamp": (future_stamp, EVERY),
    "quaternion": (quaternion, (ODOMETRY,)),
    "negative_speed": (negative_speed, (ODOMETRY, AIR_VELOCITY)),
    "absurd": (absurd, (ODOMETRY, TARGET, COMMAND)),
    "empty": (empty, (COMMAND,)),
}


class Corruption(ChangeFault, TopicFault):
    """Corrupts every other message of a topic in one way.

    Args:
        topic: That it strikes.
        word: One of :data:`CHANGES`.
    """

    name = "corruption"
    share = 0.5

    def __init__(self, topic: Topic, word: str) -> None:
        super().__init__(topic)
        self.variant, self._word = f"{FAMILIES[topic.name]}_{word}", word

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """Every way on every topic that it is for."""
        return [cls(topic, word) for word, (_, topics) in CHANGES.items() for topic in topics]

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        change, _ = CHANGES[self._word]
        change(topic, message, self.rng)
