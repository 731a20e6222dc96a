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

"""What a page can ask of a flight; every request answers why it was refused, or nothing.

Against ROS nodes these are the topics, services and parameters that a ROS user has, in a simulation
without ROS the calls of ``Controller``, plant and target. Requests may block for some seconds: a
page makes them outside of its drawing thread.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

CONTROLLER = "nmpc_controller"
SIMULATOR = "uav_simulator"
TARGET = "target_publisher"


class Steering(ABC):
    """Requests of one aircraft.

    Attributes:
        nodes: Whose parameters can be changed: of CONTROLLER, SIMULATOR, TARGET. A real autopilot
            has no SIMULATOR, a tracker no TARGET; neither is steered then.
        faults: Faults that can be injected, by name, and what each does, in words.
    """

    nodes: frozenset[str] = frozenset()
    faults: Mapping[str, str] = {}

    @abstractmethod
    def parameters(self, node: str) -> Mapping[str, Any]:
        """Values of a node's parameters as they are now, by name.

        Args:
            node: One of ``nodes``.
        """

    @abstractmethod
    def change(self, node: str, **values: Any) -> str:
        """Change parameters as a whole, or not at all.

        Args:
            node: One of ``nodes``.
            values: By name.

        Returns:
            Why it was refused, in the node's own words; empty where it was done.
        """

    @abstractmethod
    def send_target(self, east: float, north: float) -> str:
        """Send the target somewhere, to stand there at the height that it has.

        Args:
            east: In ``map`` in [m].
            north: In ``map`` in [m].

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def pause(self, still: bool) -> str:
        """Stop simulated time, or let it go on.

        Args:
            still: Whether it is to stand.

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def reset(self) -> str:
        """Put the simulated aircraft back where it started.

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def engage(self, on: bool) -> str:
        """Let the controller command, or keep it silent.

        Args:
            on: Whether it is to command.

        Returns:
            Why it was refused; empty where it was done.
        """

    @abstractmethod
    def inject(self, fault: str) -> str:
        """Let a fault happen, and end after some seconds by itself.

        Args:
            fault: One of ``faults``.

        Returns:
            Why it was refused; empty where it began.
        """
