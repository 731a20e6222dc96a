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

"""SIGKILL to a node, then a new start."""

from __future__ import annotations

import time
from collections.abc import Sequence

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.kinds import Fault

RESTART_LIMIT = 60.0  # s of wall time for a node that was killed to be heard again


class Kill(Fault):
    """Kills a node's process and starts it anew: it must be heard again.

    Loading takes wall time, which is no time of flight: the fault has settled when the new process
    is heard.

    Args:
        victim: Node to kill.
    """

    name = "kill"
    family = "process"
    duration = (0.0, 1.0)
    wall_time = True
    restarts = True

    def __init__(self, victim: str) -> None:
        self.victim = victim
        self._started: float | None = None

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each node."""
        return [cls(node) for node in NODES]

    @property
    def label(self) -> str:
        """Such as ``kill_uav_simulator``."""
        return f"{self.name}_{self.victim}"

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
