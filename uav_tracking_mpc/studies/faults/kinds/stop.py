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

"""SIGSTOP to a node, then SIGCONT."""

from __future__ import annotations

from collections.abc import Sequence

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.injected_flight import Flight
from uav_tracking_mpc.studies.faults.kinds import Fault


class Stop(Fault):
    """Freezes a node's process and lets it go on.

    Args:
        victim: Node to freeze.
    """

    name = "stop"
    family = "process"
    duration = (0.5, 3.0)
    wall_time = True

    def __init__(self, victim: str) -> None:
        self.victim = victim

    @classmethod
    def variants(cls) -> Sequence[Fault]:
        """One for each node."""
        return [cls(node) for node in NODES]

    @property
    def label(self) -> str:
        """Such as ``stop_uav_simulator``."""
        return f"{self.name}_{self.victim}"

    def begin(self, flight: Flight, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.supervisor.freeze(self.victim)

    def end(self, flight: Flight) -> None:
        """See :meth:`Fault.end`."""
        flight.supervisor.thaw(self.victim)
