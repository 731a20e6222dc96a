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

"""One fault under way: begun, gone on with, ended, settled."""

from __future__ import annotations

import copy
import time

from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.kinds import Fault


class Injection:
    """A fault that has begun.

    Args:
        fault: Which; it is copied.
        duration: How long it lasts, in simulated or wall time as the fault has it [s].
        seed: Of everything random in it.
        flight: What it acts on.

    Attributes:
        settled: Whether it has ended and its end has taken effect.
    """

    def __init__(self, fault: Fault, duration: float, seed: int, flight: Flight) -> None:
        self._fault, self._flight = copy.copy(fault), flight
        seconds = duration if fault.wall_time else duration / flight.speed
        self._end = time.monotonic() + seconds
        self._ended = self.settled = False
        self._fault.begin(flight, seconds, seed)

    def step(self) -> list[Violation]:
        """Go on with the fault, or end it when its time is over.

        Returns:
            What must hold with this fault and does not.
        """
        if time.monotonic() < self._end:
            self._fault.during(self._flight)
        else:
            self.end()
            self.settled = self._fault.settled(self._flight)
        return self._fault.violations(self._flight)

    def end(self) -> None:
        """End the fault, once."""
        if not self._ended:
            self._ended = True
            self._fault.end(self._flight)
