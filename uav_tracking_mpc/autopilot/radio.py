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

"""The wire of the simulated autopilot, on which faults act as on a radio."""

from __future__ import annotations

import heapq
import itertools

from uav_tracking_mpc.autopilot.deliveries import StreamRule, struck
from uav_tracking_mpc.links.mavlink.connection import CHUNK, Connection, Wire

Queue = list[tuple[float, int, bytes]]  # when it arrives in s, order, bytes


class Radio(Connection):
    """A connection whose bytes may be lost, late, doubled or changed on their way.

    What is sent comes as whole frames, what is received as pieces: of a datagram a frame, of a
    stream whatever was there.

    Args:
        address: As :class:`Connection` has it.
        component: MAVLink component that this end is.
        key: File with the key that signs messages; empty for none.
    """

    def __init__(self, address: str, component: int, key: str = "") -> None:
        self._faults: tuple[StreamRule, ...] = ()
        self._order = itertools.count()
        self._outward: Queue = []
        self._inward: Queue = []
        self._ended = False  # the other end has closed a stream
        super().__init__(address, component, key)

    def strike(self, fault: StreamRule) -> None:
        """Let a fault act from now on, after those that act already.

        Args:
            fault: Prepared.
        """
        self._faults = (*self._faults, fault)

    def release(self, fault: StreamRule) -> None:
        """End a fault; what it holds back still comes.

        Args:
            fault: One that acts.
        """
        self._faults = tuple(other for other in self._faults if other is not fault)

    def relay(self, frame: bytes) -> None:
        """Send what another vehicle has said.

        Args:
            frame: Packed by that vehicle.
        """
        with self._sending:
            if self._wire is not None:
                self._wire.write(frame)

    def _opened(self) -> Wire:
        wire = super()._opened()
        self._outward.clear()
        self._inward.clear()
        self._ended = False
        self._write, self._read, self._wait = wire.write, wire.recv, wire.select
        wire.write = self._sent  # type: ignore[method-assign]
        wire.recv = self._received  # type: ignore[method-assign]
        wire.select = self._ready  # type: ignore[method-assign]
        return wire

    def _sent(self, frame: bytes) -> None:
        if not self._faults and not self._outward:
            self._write(frame)
            return
        self._queue(self._outward, bytes(frame), outward=True)
        self._flush()

    def _received(self, size: int) -> bytes | None:
        """One piece: a cut one must not swallow the next."""
        if self._inward and self._inward[0][0] <= self.now():
            return heapq.heappop(self._inward)[2]
        return b"" if self._ended else None

    def _ready(self, timeout: float) -> bool:
        """Whether there is something to receive, or the other end has closed."""
        deadline = self.now() + timeout
        while True:
            self._flush()
            now = self.now()
            if self._ended or (self._inward and self._inward[0][0] <= now):
                return True
            if now > deadline:
                return False
            next_due = min((queue[0][0] for queue in (self._inward, self._outward) if queue),
                           default=deadline)  # fmt: skip
            if self._wait(max(min(deadline, next_due) - now, 0.0)):
                data = self._read(CHUNK)
                if data:
                    self._queue(self._inward, bytes(data), outward=False)
                elif data == b"":
                    self._ended = True
            elif timeout <= 0.0:
                return bool(self._inward and self._inward[0][0] <= self.now())

    def _queue(self, queue: Queue, data: bytes, outward: bool) -> None:
        now = self.now()
        for delay, piece in struck(self._faults, outward, data, now):
            heapq.heappush(queue, (now + delay, next(self._order), piece))

    def _flush(self) -> None:
        now = self.now()
        while self._outward and self._outward[0][0] <= now:
            self._write(heapq.heappop(self._outward)[2])
