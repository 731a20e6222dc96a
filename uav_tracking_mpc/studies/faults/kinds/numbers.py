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

"""Numbers that are none, attitudes that are none, and finite values that no flight has."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.stream_fault import ChangeFault, MessageFault, numbers

VALUES = {"nan": math.nan, "inf": math.inf, "huge": 1e300}
FAR = 9e6  # m; finite, within any check of plausibility that leaves room for the earth


class BadNumber(MessageFault):
    """Replaces one number of a message, of either sign.

    Args:
        topic: That it strikes.
        word: Which of the values.
    """

    name = "bad_number"

    def __init__(self, topic: Topic, word: str) -> None:
        super().__init__(topic)
        self._word = word

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """Every value on every topic."""
        return [cls(topic, word) for topic in cls.topics for word in VALUES]

    @property
    def label(self) -> str:
        """Such as ``odometry_nan``."""
        return f"{self.family}_{self._word}"

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        fields = numbers(topic, message)
        if fields:
            holder, name = self.rng.choice(fields)
            setattr(holder, name, self.rng.choice((1.0, -1.0)) * VALUES[self._word])


class Quaternion(MessageFault):
    """Sends the quaternion (0, 0, 0, 0)."""

    name = "quaternion"
    topics = (ODOMETRY,)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        q = message.pose.pose.orientation
        q.x = q.y = q.z = q.w = 0.0


class NegativeSpeed(MessageFault):
    """Turns the sign of the forward speed, over ground or through the air."""

    name = "negative_speed"
    topics = (ODOMETRY, AIR_VELOCITY)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        twist = message.twist.twist if topic == ODOMETRY else message.twist
        twist.linear.x = -twist.linear.x


class Absurd(MessageFault):
    """Sends a state or a target 9000 km away, or a command of 1000 rad/s."""

    name = "absurd"
    topics = (ODOMETRY, TARGET, COMMAND)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        choice = self.rng.choice
        if topic == COMMAND:
            for holder, name in numbers(topic, message):
                setattr(holder, name, choice((1e3, -1e3)))
            return
        place = message.point if topic == TARGET else message.pose.pose.position
        place.x, place.z = choice((FAR, -FAR)), choice((FAR, -FAR, 0.0))
        if topic == ODOMETRY:
            message.twist.twist.linear.x = choice((0.0, 900.0))


class Empty(MessageFault):
    """Sends a command without points, or points without velocities."""

    name = "empty"
    topics = (COMMAND,)

    def change(self, topic: Topic, message: Any) -> None:
        """See :meth:`ChangeFault.change`."""
        kept = self.rng.choice((0, len(message.points)))
        message.points = message.points[:kept]
        for point in message.points:
            point.velocities = []


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
