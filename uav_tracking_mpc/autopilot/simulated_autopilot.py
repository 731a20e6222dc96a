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

"""An autopilot behind its wire, in real time: for tests, and for people without a build of one."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Sequence

from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.radio import Radio
from uav_tracking_mpc.autopilot.vehicle_protocol import COMPONENT
from uav_tracking_mpc.autopilot.wired_autopilot import ORIGIN, WiredAutopilot
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.settings.configuration import Configuration

logger = logging.getLogger(__name__)

CONNECTION = "udpout:127.0.0.1:14550"
BEHIND = 1.0  # s by which the simulation may lag behind the clock before time stands still
RETRY = 0.2  # s between attempts to open a lost wire


class SimulatedAutopilot(WiredAutopilot):
    """Flies in a thread of its own from :meth:`start` to :meth:`stop`; also a context manager.

    Args:
        dialect: See :class:`WiredAutopilot`, as for the others.
        configuration: Of the mission.
        connection: As :class:`~uav_tracking_mpc.links.mavlink.connection.Connection` has it.
        origin: Latitude [deg], longitude [deg] and altitude [m] of the origin of ``map``.
        system: Its MAVLink system.
        on_runway: It stands on the ground.
        key: File with the key that signs messages; empty for none.
        target_system: MAVLink system of a vehicle on the ground; 0 for none.

    Raises:
        ParameterError: There is no such dialect, or no such place on the earth.
        LinkError: The connection cannot be opened.
    """

    def __init__(
        self,
        dialect: str,
        configuration: Configuration,
        connection: str = CONNECTION,
        origin: Sequence[float] = ORIGIN,
        system: int = 1,
        on_runway: bool = False,
        key: str = "",
        target_system: int = 0,
    ) -> None:
        wire = lambda: Radio(connection, COMPONENT, key)  # noqa: E731
        super().__init__(dialect, configuration, wire, origin, system, on_runway, target_system)
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Fly in a thread."""
        self._thread = threading.Thread(target=self.run, name="simulated_autopilot", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the flight, wait for its thread and close the wire."""
        self._ending.set()
        if self._thread is not None:
            self._thread.join()
        self.radio.close()

    def __enter__(self) -> SimulatedAutopilot:
        """Start."""
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        """Stop."""
        self.stop()

    def run(self) -> None:
        """Fly by the machine's clock until :meth:`stop` is called."""
        begin = time.monotonic() - self.core.time
        while not self._ending.is_set():
            now = time.monotonic() - begin
            if now - self.core.time > BEHIND:  # the machine was busy: its time is lost
                begin += now - self.core.time - TICK
                now = self.core.time + TICK
            self.go_on(now)
            self._listen(begin)

    def _listen(self, begin: float) -> None:
        wait = self.core.time + TICK - (time.monotonic() - begin)
        try:
            self.listen(max(wait, 0.0), lambda: time.monotonic() - begin)
        except LinkError as error:
            logger.info("%s", error)
            self._reopen()

    def _reopen(self) -> None:
        try:
            self.radio.open()
        except LinkError:
            self._ending.wait(RETRY)
