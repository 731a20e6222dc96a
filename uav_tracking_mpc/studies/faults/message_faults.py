"""What a fault does to a stream of messages: lost, late, twice, out of order, corrupted."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.studies.faults.corruption import corrupt, shift
from uav_tracking_mpc.studies.faults.fault_kinds import KINDS, TARGET

LOSS = 0.2  # share of the messages
JITTER = 0.2  # s
SHARE = 0.5  # of the messages that a corruption strikes: good ones in between are harder to handle
TURNED = 0.3  # s by which a message that loses its turn is late

Delivery = tuple[float, bytes]  # delay in simulated time [s], serialized message


class MessageFault:
    """A fault that strikes messages while it lasts.

    Args:
        kind: Name of its kind, one whose action is ``relay``.
        seed: Of everything random in it.
        reach: How far a target is teleported, in [m].
        decode: Serialized message and topic to a message that can be changed.
        encode: And back.
    """

    def __init__(
        self,
        kind: str,
        seed: int,
        reach: float,
        decode: Callable[[str, bytes], Any],
        encode: Callable[[Any], bytes],
    ) -> None:
        self._kind = KINDS[kind]
        self._rng = random.Random(seed)
        self._decode, self._encode = decode, encode
        # What is the same for every message while the fault lasts:
        azimuth = self._rng.uniform(0.0, 2.0 * math.pi)
        self._leap = (reach * math.cos(azimuth), reach * math.sin(azimuth))
        self._offset = self._rng.choice((1.0, 3.0, 30.0, 3600.0))

    def deliver(self, topic: str, data: bytes) -> list[Delivery]:
        """What arrives of a message, and how much later."""
        if topic not in self._kind.streams:
            return [(0.0, data)]
        name = self._kind.name
        if name in _WHOLE_STREAM:
            return _WHOLE_STREAM[name](self._rng, data)
        name = name.removeprefix(f"{self._kind.family}_")
        if name in ("duplicated", "reordered"):
            return _ORDER[name](self._rng, data)
        if name in ("teleport", "forward", "backward"):
            return [(0.0, self._displaced(topic, name, data))]
        if self._rng.random() > SHARE:
            return [(0.0, data)]
        message = self._decode(topic, data)
        corrupt(topic, name, message, self._rng)
        return [(0.0, self._encode(message))]

    def _displaced(self, topic: str, name: str, data: bytes) -> bytes:
        message = self._decode(topic, data)
        if topic == TARGET:
            message.point.x += self._leap[0]
            message.point.y += self._leap[1]
        else:
            shift(message.clock, self._offset if name == "forward" else -self._offset)
            if message.clock.sec < 0:  # rclpy itself ends on times before 0
                message.clock.sec = message.clock.nanosec = 0
        return self._encode(message)


def _lost(rng: random.Random, data: bytes) -> list[Delivery]:
    return []


_WHOLE_STREAM: dict[str, Callable[[random.Random, bytes], list[Delivery]]] = {
    "loss": lambda rng, data: [] if rng.random() < LOSS else [(0.0, data)],
    "jitter": lambda rng, data: [(rng.uniform(0.0, JITTER), data)],
    "gap_state": _lost,
    "gap_target": _lost,
    "gap_command": _lost,
    "target_lost": _lost,
    "clock_pause": _lost,
}
_ORDER: dict[str, Callable[[random.Random, bytes], list[Delivery]]] = {
    "duplicated": lambda rng, data: [(0.0, data), (0.0, data), (rng.uniform(0.0, TURNED), data)],
    "reordered": lambda rng, data: [(TURNED if rng.random() < SHARE else 0.0, data)],
}
