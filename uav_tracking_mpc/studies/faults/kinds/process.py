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

"""Processes that are killed, frozen, or starved by busy ones on every core."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Sequence

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.kinds import Fault

RESTART_LIMIT = 60.0  # s of wall time for a node that was killed to be heard again
PER_CORE = 2  # processes that load a core
# Ends by itself, for nobody ends it when the campaign itself is killed.
BUSY = "import time\nend = time.monotonic() + 10.0\nwhile time.monotonic() < end: pass"


class ProcessFault(Fault):
    """A fault of one node's process.

    Args:
        victim: The node.
    """

    family = "process"
    wall_time = True

    def __init__(self, victim: str) -> None:
        self.victim = victim

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each node."""
        return [cls(node) for node in NODES]

    @property
    def label(self) -> str:
        """Such as ``kill_uav_simulator``."""
        return f"{self.name}_{self.victim}"


class Kill(ProcessFault):
    """Kills a node's process and starts it anew: it must be heard again.

    Loading takes wall time, which is no time of flight: the fault has settled when the new process
    is heard.
    """

    name = "kill"
    duration = (0.0, 1.0)
    restarts = True
    _started: float | None = None

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.supervisor.kill(self.victim)

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        flight.supervisor.restart(self.victim)
        self._started = time.monotonic()

    def settled(self, flight: Flight) -> bool:
        """See :meth:`Fault.settled`."""
        assert self._started is not None
        return self._overdue or flight.observer.heard.get(self.victim, 0.0) >= self._started

    def violations(self, flight: Flight) -> list[Violation]:
        """See :meth:`Fault.violations`."""
        if not self._overdue:
            return []
        words = f"{self.victim} was not heard within {RESTART_LIMIT:g} s of its new start"
        return [Violation("restart", words)]

    @property
    def _overdue(self) -> bool:
        return self._started is not None and time.monotonic() - self._started > RESTART_LIMIT


class Stop(ProcessFault):
    """Freezes a node's process and lets it go on."""

    name = "stop"
    duration = (0.5, 3.0)

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.supervisor.freeze(self.victim)

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        flight.supervisor.thaw(self.victim)


class CpuStarvation(Fault):
    """Starts two busy processes for every core and ends them."""

    name = "cpu_starvation"
    family = "process"
    duration = (0.5, 2.0)
    wall_time = True

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        program = [sys.executable, "-S", "-c", BUSY]
        self._busy = [
            subprocess.Popen(program, stdin=subprocess.DEVNULL)
            for _ in range(PER_CORE * (os.cpu_count() or 1))
        ]

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        for process in self._busy:
            process.kill()
            process.wait()
