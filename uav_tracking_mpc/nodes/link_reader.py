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

"""A thread that reaches an aircraft through a link and hands over what it measures."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import LinkError, LinkRefusedError, VehicleLink

CONNECT_LIMIT = 4.0  # s of one attempt to reach the aircraft
RETRY_PERIOD = 1.0  # s from one attempt to the next
WAIT = 0.1  # s for a measurement, and so to notice that it is to stop
STOP_LIMIT = 1.0  # s for the thread to end


class LinkReader:
    """Connects, again and again while there is no aircraft, and reads until it is stopped.

    Args:
        link: To be read; this thread alone connects it.
        taken: Called with each measurement, in this thread; what it raises is reported among
            the link's events.

    Attributes:
        connected: Whether the aircraft was reached.
        trouble: Why there is no aircraft, in words; empty while there is one.
        refusal: Why it is given up, in words; empty while it is not.
    """

    def __init__(self, link: VehicleLink, taken: Callable[[Measurement], None]) -> None:
        self._link, self._taken = link, taken
        self.connected, self.trouble, self.refusal = False, "not connected yet", ""
        self._told = ""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="link", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread, then the link; the aircraft does as the link's ``when_silent`` says."""
        self._stop.set()
        with contextlib.suppress(Exception):  # whatever a user's link raises, it is let go
            self._link.disengage()
        self._thread.join(STOP_LIMIT)
        with contextlib.suppress(Exception):
            self._link.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                self._link.connect(CONNECT_LIMIT)
                self.connected, self.trouble = True, ""
                self._read()
            except LinkRefusedError as error:
                self.refusal = str(error)
                return
            except LinkError as error:
                self.trouble = str(error)
            except Exception as error:  # whatever a user's link raises, it is tried again
                self.trouble = f"the link failed: {type(error).__name__}: {error}"
            self.connected = False
            if self._stop.wait(RETRY_PERIOD):
                return
            with contextlib.suppress(Exception):  # connecting begins anew
                self._link.close()

    def _read(self) -> None:
        while not self._stop.is_set():
            measurement = self._link.measured(WAIT)
            if measurement is None or self._stop.is_set():
                continue
            try:
                self._taken(measurement)
            except Exception as error:  # not the link's: it is flown on
                words = f"a measurement is not published: {type(error).__name__}: {error}"
                if words != self._told:
                    self._told = words
                    self._link.events.add(Level.WARNING, words)
