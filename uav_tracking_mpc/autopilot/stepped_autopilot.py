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

"""An autopilot behind its wire in simulated time: flights of minutes take seconds, and repeat.

The wire is two queues of datagrams in memory. Whoever waits at our end of it makes time go on, so a
link flies as it flies in real time, without threads, and the same seeds give the same flight.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.radio import Radio
from uav_tracking_mpc.autopilot.simulated_autopilot import ORIGIN, WiredAutopilot
from uav_tracking_mpc.autopilot.vehicle_protocol import COMPONENT
from uav_tracking_mpc.links.mavlink.connection import Connection, Wire
from uav_tracking_mpc.settings.configuration import Configuration

DATAGRAMS = "udpin:127.0.0.1:1"  # the form of an address; nothing is opened there
CAPACITY = 2000  # datagrams that wait; the oldest are dropped first, as a socket drops the newest


class _End(Wire):
    """One end of the wire."""

    def __init__(self) -> None:
        self.incoming: deque[bytes] = deque(maxlen=CAPACITY)
        self.other: _End | None = None

    def write(self, frame: bytes) -> None:
        if self.other is not None:
            self.other.incoming.append(bytes(frame))

    def recv(self, size: int) -> bytes | None:
        return self.incoming.popleft() if self.incoming else None

    def select(self, timeout: float) -> bool:
        return bool(self.incoming)

    def close(self) -> None:
        self.incoming.clear()


class SteppedAutopilot(WiredAutopilot):
    """Goes on while a link that was made with :meth:`connection` waits.

    Args:
        dialect: See :class:`WiredAutopilot`, as for the others.
        configuration: Of the mission.
        origin: Latitude [deg], longitude [deg] and altitude [m] of the origin of ``map``.
        on_runway: It stands on the ground.

    Attributes:
        time: Simulated, in [s].

    Raises:
        ParameterError: There is no such dialect, or no such place on the earth.
    """

    def __init__(
        self,
        dialect: str,
        configuration: Configuration,
        origin: Sequence[float] = ORIGIN,
        on_runway: bool = False,
    ) -> None:
        self.time = 0.0
        self.ends = _End(), _End()
        ours, theirs = self.ends
        ours.other, theirs.other = theirs, ours
        super().__init__(
            dialect, configuration, lambda: _SteppedRadio(self, 1, COMPONENT), origin, 1, on_runway
        )

    def connection(self, address: str, component: int, key: str) -> Connection:
        """Our end of the wire.

        Args:
            address: Has no meaning here.
            component: MAVLink component that we are.
            key: Has no meaning here.
        """
        return _SteppedConnection(self, 0, component)

    def tick(self) -> None:
        """Go on by one tick."""
        self.time += TICK
        self.go_on(self.time)
        while self.radio.wait(0.0):
            self.listen(0.0, lambda: self.time)


class _Stepped(Connection):
    """One end of the wire, by simulated time."""

    def __init__(self, autopilot: SteppedAutopilot, end: int, component: int) -> None:
        self._autopilot, self._end = autopilot, autopilot.ends[end]
        super().__init__(DATAGRAMS, component)

    def now(self) -> float:
        return self._autopilot.time

    def _socket(self) -> Wire:
        return self._end


class _SteppedRadio(_Stepped, Radio):
    """The autopilot's end."""


class _SteppedConnection(_Stepped):
    """Our end; waiting at it makes time go on."""

    def wait(self, timeout: float) -> bool:
        ticks = math.ceil(timeout / TICK)  # time moves on however short the wait
        while not self._end.incoming and ticks > 0:
            self._autopilot.tick()
            ticks -= 1
        return bool(self._end.incoming)
