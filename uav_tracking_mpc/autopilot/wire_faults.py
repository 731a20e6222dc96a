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

"""The wire of the simulated autopilot, and faults on it, by name, each with a beginning and an end.

They are for campaigns: :class:`~uav_tracking_mpc.autopilot.simulated_autopilot.SimulatedAutopilot`
begins and ends them. All that is random in one comes from a seed. What may happen to any stream is
in :mod:`~uav_tracking_mpc.autopilot.deliveries`; here is what only a wire or its autopilot suffers.
"""

from __future__ import annotations

import heapq
import itertools
import random
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from uav_tracking_mpc.autopilot.deliveries import (
    BitFlips,
    Bursts,
    Delivery,
    Duplicated,
    Jitter,
    Latency,
    Loss,
    Reordered,
    Silence,
    Stale,
    StreamRule,
    Truncated,
    struck,
)
from uav_tracking_mpc.links.mavlink.connection import CHUNK, Wire
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.parameters.specification import ParameterError

if TYPE_CHECKING:
    from uav_tracking_mpc.autopilot.simulated_autopilot import WiredAutopilot

STRANGER = 77  # code: MAVLink system of the other vehicle


class AutopilotFault(StreamRule):
    """A fault that acts on the autopilot behind the wire, too."""

    def begin(self, autopilot: WiredAutopilot) -> None:
        """Begin.

        Args:
            autopilot: Behind the wire.
        """

    def end(self, autopilot: WiredAutopilot) -> None:
        """End.

        Args:
            autopilot: Behind the wire.
        """


class Mute(StreamRule):
    """The autopilot hears and is not heard."""

    name = "mute"
    _lost = True  # of what it sends

    def deliver(self, stream: bool, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        return [] if stream is self._lost else [(0.0, piece)]


class Deaf(Mute):
    """The autopilot is heard and does not hear."""

    name = "deaf"
    _lost = False


class Garbage(StreamRule):
    """Random bytes between the pieces, some of which begin as frames do."""

    name = "garbage"

    def deliver(self, stream: bool, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        if not self.strikes():
            return [(0.0, piece)]
        noise = self.rng.randbytes(self.rng.randint(1, 300))
        return [(0.0, self.rng.choice([b"", b"\xfd", b"\xfe"]) + noise), (0.0, piece)]


class Stranger(StreamRule):
    """Another vehicle is on the air, a copter of another system, elsewhere and in another mode."""

    name = "stranger"

    def __init__(self) -> None:
        self._voice = mavlink.MAVLink(None, STRANGER, 1)

    def deliver(self, stream: bool, piece: bytes) -> Sequence[Delivery]:
        """See :meth:`StreamRule.deliver`."""
        if not stream or not self.strikes():
            return [(0.0, piece)]
        rng, when = self.rng, self.rng.randrange(2**32)
        numbers = [rng.randint(-(2**15), 2**15 - 1) for _ in range(3)]
        where = [rng.randint(-(10**8), 10**8) for _ in range(4)]
        rates = [rng.uniform(-3.0, 3.0) for _ in range(6)]
        kind, maker = mavlink.MAV_TYPE_QUADROTOR, rng.choice([3, 12])
        message = rng.choice(
            [
                mavlink.MAVLink_heartbeat_message(kind, maker, 81, 0, 4, 3),
                mavlink.MAVLink_global_position_int_message(when, *where, *numbers, 0),
                mavlink.MAVLink_attitude_message(when, *rates),
                mavlink.MAVLink_command_ack_message(176, mavlink.MAV_RESULT_DENIED),
                mavlink.MAVLink_param_value_message(b"ROLL_LIMIT_DEG", 5.0, 9, 1, 0),
            ]
        )
        return [(0.0, bytes(message.pack(self._voice))), (0.0, piece)]


class ClockJump(AutopilotFault):
    """The autopilot's clock jumps, and back at the end."""

    name = "clock_jump"

    def begin(self, autopilot: WiredAutopilot) -> None:
        """See :meth:`AutopilotFault.begin`."""
        self._seconds = self.rng.choice([-1.0, 1.0]) * self.rng.uniform(0.5, 30.0)
        autopilot.jump_clock(self._seconds)

    def end(self, autopilot: WiredAutopilot) -> None:
        """See :meth:`AutopilotFault.end`."""
        autopilot.jump_clock(-self._seconds)


class Restart(Silence, AutopilotFault):
    """The autopilot boots anew, in silence."""

    name = "restart"
    duration = (1.0, 3.0)

    def begin(self, autopilot: WiredAutopilot) -> None:
        """See :meth:`AutopilotFault.begin`."""
        autopilot.restart()


WIRE_FAULTS: dict[str, type[StreamRule]] = {
    fault.name: fault
    for fault in (
        BitFlips, Bursts, ClockJump, Deaf, Duplicated, Garbage, Jitter, Latency, Loss, Mute,
        Reordered, Restart, Silence, Stale, Stranger, Truncated,
    )
}  # fmt: skip


def wire_fault(name: str, seed: int = 0) -> StreamRule:
    """A new fault of a name.

    Args:
        name: One of :data:`WIRE_FAULTS`.
        seed: Of everything random in it.

    Raises:
        ParameterError: There is none of that name.
    """
    if name not in WIRE_FAULTS:
        raise ParameterError(f"fault is {name!r}, must be one of {', '.join(WIRE_FAULTS)}")
    fault = WIRE_FAULTS[name]()
    fault.rng = random.Random(seed)
    return fault


Queue = list[tuple[float, int, bytes]]  # when it arrives in s, order, bytes


class Radio(Wire):
    """A wire whose bytes may be lost, late, doubled or changed on their way.

    What is sent comes as whole frames, what is received as pieces: of a datagram a frame, of a
    stream whatever was there.

    Args:
        wire: What carries them.
        faults: That act now, one after the other.
        now: Time in [s].
    """

    def __init__(
        self, wire: Wire, faults: list[StreamRule], now: Callable[[], float] = time.monotonic
    ) -> None:
        super().__init__(None)
        self._wire, self._faults, self._now = wire, faults, now
        self._order = itertools.count()
        self._outward: Queue = []
        self._inward: Queue = []
        self._ended = False  # the other end has closed a stream

    def write(self, frame: bytes) -> None:
        """See :meth:`Wire.write`."""
        if not self._faults and not self._outward:
            self._wire.write(frame)
            return
        self._queue(self._outward, bytes(frame), outward=True)
        self._flush()

    def recv(self, size: int) -> bytes | None:
        """See :meth:`Wire.recv`: one piece, for a cut one must not swallow the next."""
        if self._inward and self._inward[0][0] <= self._now():
            return heapq.heappop(self._inward)[2]
        return b"" if self._ended else None

    def select(self, timeout: float) -> bool:
        """See :meth:`Wire.select`."""
        deadline = self._now() + timeout
        while True:
            self._flush()
            now = self._now()
            if self._ended or (self._inward and self._inward[0][0] <= now):
                return True
            if now > deadline:
                return False
            next_due = min((queue[0][0] for queue in (self._inward, self._outward) if queue),
                           default=deadline)  # fmt: skip
            if self._wire.select(max(min(deadline, next_due) - now, 0.0)):
                data = self._wire.recv(CHUNK)
                if data:
                    self._queue(self._inward, bytes(data), outward=False)
                elif data == b"":
                    self._ended = True
            elif timeout <= 0.0:
                return bool(self._inward and self._inward[0][0] <= self._now())

    def close(self) -> None:
        """See :meth:`Wire.close`."""
        self._wire.close()

    def _queue(self, queue: Queue, data: bytes, outward: bool) -> None:
        now = self._now()
        for delay, piece in struck(tuple(self._faults), outward, data, now):
            heapq.heappush(queue, (now + delay, next(self._order), piece))

    def _flush(self) -> None:
        now = self._now()
        while self._outward and self._outward[0][0] <= now:
            self._wire.write(heapq.heappop(self._outward)[2])
