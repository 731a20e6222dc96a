"""What a corruption does to the fields of a message; each changes the message in place."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.studies.faults.fault_kinds import AIR, ODOMETRY, TARGET

LATEST_STAMP = 2**31 - 1  # s, where builtin_interfaces/Time ends
FAR = 9e6  # m; finite, within any check of plausibility that leaves room for the earth

Field = tuple[Any, str]


def corrupt(topic: str, name: str, message: Any, rng: random.Random) -> None:
    """Corrupt a message.

    Args:
        topic: Name of its topic.
        name: One of :data:`CORRUPTIONS` or what ``fault_kinds`` adds for the topic.
        message: Changed in place.
        rng: For what is random in it.
    """
    _CORRUPTIONS[name](topic, message, rng)


def numbers(topic: str, message: Any) -> list[Field]:
    """Fields of a message that hold what a controller or a vehicle computes with."""
    if topic == ODOMETRY:
        pose = message.pose.pose
        linear = message.twist.twist.linear
        return [*_axes(pose.position), (pose.orientation, "w"), *_axes(linear)]
    if topic == TARGET:
        return _axes(message.point)
    if topic == AIR:
        return _axes(message.twist.linear)
    return [
        field
        for point in message.points
        for field in (
            (point.velocities[0].angular, "y"),
            (point.velocities[0].angular, "z"),
            (point.accelerations[0].linear, "x"),
        )
    ]


def shift(stamp: Any, seconds: float) -> None:
    """Move a stamp, as far as a stamp can go; times before 0 exist in messages, but not for all."""
    total = stamp.sec * 10**9 + stamp.nanosec + round(seconds * 1e9)
    total = min(max(total, -(2**31) * 10**9), LATEST_STAMP * 10**9)
    stamp.sec, stamp.nanosec = divmod(total, 10**9)


def _axes(vector: Any) -> list[Field]:
    return [(vector, axis) for axis in "xyz"]


def _one_number(value: float) -> Callable[[str, Any, random.Random], None]:
    def put(topic: str, message: Any, rng: random.Random) -> None:
        fields = numbers(topic, message)
        if fields:
            holder, name = rng.choice(fields)
            setattr(holder, name, rng.choice((1.0, -1.0)) * value)

    return put


def _frame(topic: str, message: Any, rng: random.Random) -> None:
    message.header.frame_id = rng.choice(("", "odom", "MAP", "map" * 1000))


def _old_stamp(topic: str, message: Any, rng: random.Random) -> None:
    shift(message.header.stamp, -rng.uniform(3.0, 20.0))


def _future_stamp(topic: str, message: Any, rng: random.Random) -> None:
    shift(message.header.stamp, rng.choice((rng.uniform(0.2, 20.0), 1e10)))


def _quaternion(topic: str, message: Any, rng: random.Random) -> None:
    q = message.pose.pose.orientation
    q.x = q.y = q.z = q.w = 0.0


def _negative_speed(topic: str, message: Any, rng: random.Random) -> None:
    linear = message.twist.twist.linear if topic == ODOMETRY else message.twist.linear
    linear.x = -linear.x


def _absurd(topic: str, message: Any, rng: random.Random) -> None:
    """Finite and in the right frame, but no state, place or command of this flight."""
    if topic == ODOMETRY:
        position = message.pose.pose.position
        position.x, position.z = rng.choice((FAR, -FAR, 0.0)), rng.choice((FAR, -FAR, 0.0))
        message.twist.twist.linear.x = rng.choice((0.0, 900.0))
    elif topic == TARGET:
        message.point.x, message.point.z = rng.choice((FAR, -FAR)), rng.choice((FAR, -FAR, 0.0))
    else:
        for holder, name in numbers(topic, message):
            setattr(holder, name, rng.choice((1e3, -1e3)))


def _empty(topic: str, message: Any, rng: random.Random) -> None:
    if rng.random() < 0.5:
        message.points = []
        return
    for point in message.points:
        point.velocities = []


_CORRUPTIONS: dict[str, Callable[[str, Any, random.Random], None]] = {
    "nan": _one_number(math.nan),
    "inf": _one_number(math.inf),
    "huge": _one_number(1e300),
    "frame": _frame,
    "old_stamp": _old_stamp,
    "future_stamp": _future_stamp,
    "quaternion": _quaternion,
    "negative_speed": _negative_speed,
    "absurd": _absurd,
    "empty": _empty,
}
