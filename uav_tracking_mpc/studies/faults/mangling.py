"""Streams of messages on their way from a sender gone wrong: lost, twice, swapped, mutated."""

from __future__ import annotations

import copy
import random
from typing import Any

from uav_tracking_mpc.studies.faults.corruption import corrupt
from uav_tracking_mpc.studies.faults.fault_kinds import AIR, COMMAND, CORRUPTIONS, ODOMETRY, TARGET
from uav_tracking_mpc.studies.faults.mutations import extreme_stamp, mutate, scale_quaternion

LEAP = 1e3  # m
OF_TOPIC = {
    ODOMETRY: ("quaternion", "negative_speed", "absurd"),
    AIR: ("negative_speed",),
    TARGET: ("absurd",),
    COMMAND: ("absurd", "empty"),
}
TWIN = 10_000_000  # ns from one message to the other that bears it out
LATEST_NANOSECOND = 2**32 - 1  # where the field ends; a time ends at 10^9
STRETCH = 100  # messages that one share of bad ones lasts
SHARES = (0.0, 0.02, 0.3, 0.7, 1.0)


class Mangler:
    """What arrives of one topic.

    Args:
        topic: Its name.
        seed: Of everything random.

    Attributes:
        calm: Messages since the last one that was not delivered as it was sent.
    """

    def __init__(self, topic: str, seed: int) -> None:
        self._topic = topic
        self._rng = random.Random(f"{topic} {seed}")
        self._held: Any = None
        self._left, self._share = 0, 0.0
        self.calm = 0

    def deliver(self, message: Any) -> list[Any]:
        """Messages that arrive now that this one, which is nobody else's, is sent."""
        rng = self._rng
        if self._left == 0:
            # Long enough now and then for whatever is wrong to be over.
            self._share = rng.choice(SHARES)
            self._left = STRETCH if self._share else 4 * STRETCH
        self._left -= 1
        held, self._held = self._held, None
        after = [] if held is None else [held]
        if rng.random() >= self._share:
            self.calm = 0 if after else self.calm + 1
            return [message, *after]
        self.calm = 0
        choice = rng.random()
        if choice < 0.05:
            return after  # lost
        if choice < 0.10:
            self._held = message  # swapped with the next
            return after
        if choice < 0.15:
            return [message, message, *after]
        self._spoil(message)
        if choice < 0.25:  # two that agree
            twin = copy.deepcopy(message)
            stamp = twin.header.stamp
            stamp.nanosec = min(stamp.nanosec + TWIN, LATEST_NANOSECOND)  # sometimes no time
            return [message, twin, *after]
        return [message, *after]

    def _spoil(self, message: Any) -> None:
        rng = self._rng
        choice = rng.random()
        if choice < 0.3:
            corrupt(self._topic, rng.choice((*CORRUPTIONS, *OF_TOPIC[self._topic])), message, rng)
        elif choice < 0.35:
            extreme_stamp(message.header.stamp, rng)
        elif choice < 0.4 and self._topic == ODOMETRY:
            scale_quaternion(message.pose.pose.orientation, rng)
        elif choice < 0.5 and self._topic in (ODOMETRY, TARGET):
            point = message.point if self._topic == TARGET else message.pose.pose.position
            for axis in "xyz":
                setattr(point, axis, getattr(point, axis) + rng.uniform(-LEAP, LEAP))
        else:
            for _ in range(rng.choice((1, 1, 2, 5))):
                mutate(message, rng)
