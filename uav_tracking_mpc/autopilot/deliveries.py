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

"""What arrives of a stream, and how much later: rules for the messages of a topic and for a wire.

A piece of a stream is a message, or what came at once over a wire.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Iterable, Sequence
from typing import Any

Delivery = tuple[float, bytes]  # how much later in s, and what arrives
STALE_AGE = 3.0  # s, of what is repeated


class StreamRule:
    """Decides what arrives of a stream while a fault lasts; by itself it changes nothing.

    Attributes:
        name: By which a fault that follows it is found.
        duration: Shortest and longest time that the fault lasts in [s].
        share: Of the pieces that it strikes; good ones in between are harder to handle [-].
        latest: By how much a piece is late at most in [s].
        rng: For everything random in it; set before the first piece.
        now: When a piece was sent in [s]; set before each.
    """

    name: str
    duration: tuple[float, float] = (2.0, 6.0)
    share: float = 0.3
    latest: float = 0.3
    rng: random.Random
    now = 0.0

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """What arrives of a piece, and how much later.

        Args:
            stream: Topic, or whether an autopilot sends the piece rather than receives it.
            piece: As it was sent.
        """
        return [(0.0, piece)]

    def strikes(self) -> bool:
        """Whether the next piece is struck."""
        return self.rng.random() < self.share


class Loss(StreamRule):
    """Loses a share of the pieces."""

    name = "loss"

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return [] if self.strikes() else [(0.0, piece)]


class Silence(StreamRule):
    """Loses everything."""

    name = "silence"
    duration = (3.0, 8.0)

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return []


class Bursts(StreamRule):
    """Bursts of silence, 0.2 to 1 s long, with as much between them."""

    name = "bursts"
    _change, _silent = -math.inf, False

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        while self.now >= self._change:
            self._change = max(self._change, self.now) + self.rng.uniform(0.2, 1.0)
            self._silent = not self._silent
        return [] if self._silent else [(0.0, piece)]


class Latency(StreamRule):
    """Delivers everything 400 ms later."""

    name = "latency"
    latest = 0.4

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return [(self.latest, piece)]


class Jitter(StreamRule):
    """Delivers each piece up to 200 ms later, in order or not."""

    name = "jitter"
    latest = 0.2

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return [(self.rng.uniform(0.0, self.latest), piece)]


class Reordered(StreamRule):
    """Holds a share of the pieces back, behind later ones."""

    name = "reordered"

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return [(self.latest if self.strikes() else 0.0, piece)]


class Duplicated(StreamRule):
    """Delivers a piece twice at once and a third time later."""

    name = "duplicated"

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return [(0.0, piece), (0.0, piece), (self.rng.uniform(0.0, self.latest), piece)]


class Stale(StreamRule):
    """Repeats what was sent seconds ago among what is new."""

    name = "stale"

    def __init__(self) -> None:
        self._kept: deque[tuple[float, Any, bytes]] = deque(maxlen=2000)

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        self._kept.append((self.now, stream, piece))
        since, source, old = self._kept[0]
        if self.now - since <= STALE_AGE:
            return [(0.0, piece)]
        self._kept.popleft()
        return [(0.0, piece), (0.0, old)] if source == stream else [(0.0, piece)]


class Truncated(StreamRule):
    """Cuts a share of the pieces off."""

    name = "truncated"

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        cut = self.rng.randrange(len(piece)) if self.strikes() else len(piece)
        return [(0.0, piece[:cut])] if cut else []


class BitFlips(StreamRule):
    """Turns up to four bits of a piece over."""

    name = "bit_flips"

    def deliver(self, stream: Any, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        changed = bytearray(piece)
        for _ in range(self.rng.randint(1, 4) if self.strikes() else 0):
            changed[self.rng.randrange(len(changed))] ^= 1 << self.rng.randrange(8)
        return [(0.0, bytes(changed))]


def struck(rules: Iterable[StreamRule], stream: Any, piece: bytes, now: float) -> list[Delivery]:
    """What arrives of a piece under several rules, one after the other.

    Args:
        rules: Under which it is sent.
        stream: As :meth:`StreamRule.deliver` has it.
        piece: As it was sent.
        now: When it is sent in [s].
    """
    pieces: list[Delivery] = [(0.0, piece)]
    for rule in rules:
        rule.now = now
        pieces = [
            (delay + more, changed)
            for delay, whole in pieces
            for more, changed in rule.deliver(stream, whole)
        ]
    return pieces
