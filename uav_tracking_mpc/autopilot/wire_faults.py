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

"""Faults on the wire of the simulated autopilot, by name, each with a beginning and an end.

They are for campaigns: :class:`~uav_tracking_mpc.autopilot.simulated_autopilot.SimulatedAutopilot`
begins and ends them. All that is random in one comes from a seed.
"""

from __future__ import annotations

import math
import random
from abc import ABC
from collections import deque
from collections.abc import Sequence
from typing import ClassVar, Protocol

from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.parameters.specification import ParameterError

Delivery = tuple[float, bytes]  # how much later in s, and what arrives
CHANGED_SHARE = 0.3  # of the pieces: good ones in between are harder to handle
STALE_AGE = 3.0  # s, of what is repeated
STRANGER = 77  # MAVLink system of the other vehicle


class Struck(Protocol):
    """The autopilot, as far as faults act on more than its wire."""

    def restart(self) -> None:
        """Boot anew in flight."""

    def jump_clock(self, seconds: float) -> None:
        """Set the clock.

        Args:
            seconds: By how much it goes forward in [s].
        """


class WireFault(ABC):
    """One fault under way.

    Args:
        seed: Of everything random in it.

    Attributes:
        name: By which it is found.
        duration: Shortest and longest time that it lasts in [s].
        random: Its own numbers.
    """

    name: ClassVar[str]
    duration: ClassVar[tuple[float, float]] = (2.0, 6.0)

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def begin(self, autopilot: Struck) -> None:  # noqa: B027 - most act on the wire alone
        """Begin.

        Args:
            autopilot: Behind the wire.
        """

    def end(self, autopilot: Struck) -> None:  # noqa: B027
        """End.

        Args:
            autopilot: Behind the wire.
        """

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """What arrives of a piece, and how much later.

        Args:
            piece: A frame, or what came at once of a stream.
            outward: Whether the autopilot sends it.
            now: In [s].
        """
        return [(0.0, piece)]

    def strikes(self) -> bool:
        """Whether the next piece is one of those that are changed."""
        return self.random.random() < CHANGED_SHARE


class Loss(WireFault):
    """Loses three pieces in ten, both ways."""

    name = "loss"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [] if self.strikes() else [(0.0, piece)]


class Silence(WireFault):
    """Nothing arrives, either way."""

    name = "silence"
    duration = (3.0, 8.0)

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return []


class Mute(WireFault):
    """The autopilot hears and is not heard."""

    name = "mute"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [] if outward else [(0.0, piece)]


class Deaf(WireFault):
    """The autopilot is heard and does not hear."""

    name = "deaf"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [(0.0, piece)] if outward else []


class Bursts(WireFault):
    """Bursts of silence, 0.2 to 1 s long, with as much between them.

    Args:
        seed: Of everything random in it.
    """

    name = "bursts"

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._change, self._silent = -math.inf, False

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        while now >= self._change:
            self._change = max(self._change, now) + self.random.uniform(0.2, 1.0)
            self._silent = not self._silent
        return [] if self._silent else [(0.0, piece)]


class Latency(WireFault):
    """Everything comes 400 ms later, both ways."""

    name = "latency"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [(0.4, piece)]


class Jitter(WireFault):
    """Each piece comes up to 0.2 s later, in order or not."""

    name = "jitter"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [(self.random.uniform(0.0, 0.2), piece)]


class Reordered(WireFault):
    """Holds three pieces in ten back by 0.3 s, behind later ones."""

    name = "reordered"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [(0.3 if self.strikes() else 0.0, piece)]


class Duplicated(WireFault):
    """Delivers a piece twice at once and a third time later."""

    name = "duplicated"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        return [(0.0, piece), (0.0, piece), (self.random.uniform(0.0, 0.3), piece)]


class Stale(WireFault):
    """Repeats what was sent seconds ago among what is new.

    Args:
        seed: Of everything random in it.
    """

    name = "stale"

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._kept: deque[tuple[float, bytes, bool]] = deque(maxlen=2000)

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        self._kept.append((now, piece, outward))
        delivered = [(0.0, piece)]
        since, old, direction = self._kept[0]
        if now - since > STALE_AGE:
            self._kept.popleft()
            if direction == outward:
                delivered.append((0.0, old))
        return delivered


class Garbage(WireFault):
    """Random bytes between the pieces, some of which begin as frames do."""

    name = "garbage"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        if not self.strikes():
            return [(0.0, piece)]
        noise = self.random.randbytes(self.random.randint(1, 300))
        begin = self.random.choice([b"", b"\xfd", b"\xfe"])
        return [(0.0, begin + noise), (0.0, piece)]


class Truncated(WireFault):
    """Cuts pieces off."""

    name = "truncated"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        cut = self.random.randrange(len(piece)) if self.strikes() else len(piece)
        return [(0.0, piece[:cut])] if cut else []


class BitFlips(WireFault):
    """Turns up to four bits of a piece over."""

    name = "bit_flips"

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        changed = bytearray(piece)
        if self.strikes():
            for _ in range(self.random.randint(1, 4)):
                changed[self.random.randrange(len(changed))] ^= 1 << self.random.randrange(8)
        return [(0.0, bytes(changed))]


class Stranger(WireFault):
    """Another vehicle is on the air, a copter of another system, elsewhere and in another mode.

    Args:
        seed: Of everything random in it.
    """

    name = "stranger"

    def __init__(self, seed: int) -> None:
        super().__init__(seed)
        self._voice = mavlink.MAVLink(None, STRANGER, 1)

    def deliver(self, piece: bytes, outward: bool, now: float) -> Sequence[Delivery]:
        """See :meth:`WireFault.deliver`."""
        if not outward or not self.strikes():
            return [(0.0, piece)]
        kind, maker = mavlink.MAV_TYPE_QUADROTOR, self.random.choice([3, 12])
        numbers = [self.random.randint(-(2**15), 2**15 - 1) for _ in range(3)]
        where = [self.random.randint(-(10**8), 10**8) for _ in range(4)]
        rates = [self.random.uniform(-3.0, 3.0) for _ in range(6)]
        when = self.random.randrange(2**32)
        message = self.random.choice(
            [
                mavlink.MAVLink_heartbeat_message(kind, maker, 81, 0, 4, 3),
                mavlink.MAVLink_global_position_int_message(when, *where, *numbers, 0),
                mavlink.MAVLink_attitude_message(when, *rates),
                mavlink.MAVLink_command_ack_message(176, mavlink.MAV_RESULT_DENIED),
                mavlink.MAVLink_param_value_message(b"ROLL_LIMIT_DEG", 5.0, 9, 1, 0),
            ]
        )
        return [(0.0, bytes(message.pack(self._voice))), (0.0, piece)]


class ClockJump(WireFault):
    """The autopilot's clock jumps, and back at the end."""

    name = "clock_jump"

    def begin(self, autopilot: Struck) -> None:
        """See :meth:`WireFault.begin`."""
        self._seconds = self.random.choice([-1.0, 1.0]) * self.random.uniform(0.5, 30.0)
        autopilot.jump_clock(self._seconds)

    def end(self, autopilot: Struck) -> None:
        """See :meth:`WireFault.end`."""
        autopilot.jump_clock(-self._seconds)


class Restart(Silence):
    """The autopilot boots anew, in silence."""

    name = "restart"
    duration = (1.0, 3.0)

    def begin(self, autopilot: Struck) -> None:
        """See :meth:`WireFault.begin`."""
        autopilot.restart()


WIRE_FAULTS: dict[str, type[WireFault]] = {
    fault.name: fault
    for fault in (
        BitFlips, Bursts, ClockJump, Deaf, Duplicated, Garbage, Jitter, Latency, Loss, Mute,
        Reordered, Restart, Silence, Stale, Stranger, Truncated,
    )
}  # fmt: skip


def wire_fault(name: str, seed: int = 0) -> WireFault:
    """A new fault of a name.

    Args:
        name: One of :data:`WIRE_FAULTS`.
        seed: Of everything random in it.

    Raises:
        ParameterError: There is none of that name.
    """
    if name not in WIRE_FAULTS:
        raise ParameterError(f"fault is {name!r}, must be one of {', '.join(WIRE_FAULTS)}")
    return WIRE_FAULTS[name](seed)
