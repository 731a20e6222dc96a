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

"""Real nodes in processes, watched from here: heard, sampled, and ended with who watches them."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rich.console import Console

from uav_tracking_mpc.control.guidance import compile_flight
from uav_tracking_mpc.launch.flight import signals
from uav_tracking_mpc.launch.supervisor import NODES, Supervisor, supervised
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.resources import Growth, usage

CHECK_PERIOD = 0.02  # s of wall time between looks at the processes
SAMPLE_PERIOD = 1.0  # s of wall time between looks at what they use
LOG = "nodes.log"


class WatchedNodes:
    """Processes of nodes, and the nodes of this process that hear them.

    Args:
        supervisor: Of the processes.
        received: Fills with the signals that come.

    Attributes:
        supervisor: As above.
        growth: What each process of the three nodes of a flight used, by name and id; also of
            those that were killed since.
    """

    def __init__(self, supervisor: Supervisor, received: list[int]) -> None:
        self.supervisor = supervisor
        self.growth: dict[tuple[str, int], Growth] = {}
        self._received, self._executor = received, EventsExecutor()
        self._nodes: list[Node] = []
        self._checked = self._sampled = time.monotonic()

    def hear(self, *nodes: Node) -> None:
        """Let nodes of this process hear messages."""
        self._nodes += nodes
        for node in nodes:
            self._executor.add_node(node)

    def spin(self) -> Iterator[float]:
        """Hear messages; yield the steady time in [s] every CHECK_PERIOD.

        A signal raises KeyboardInterrupt here alone: within a callback, rclpy may turn that
        exception into others.
        """
        while True:
            self._executor.spin_once(timeout_sec=CHECK_PERIOD)
            if self._received:
                raise KeyboardInterrupt
            now = time.monotonic()
            if now - self._sampled > SAMPLE_PERIOD:
                self._sampled = now
                self._sample(now)
            if now - self._checked >= CHECK_PERIOD:
                self._checked = now
                yield now

    def _sample(self, now: float) -> None:
        self.supervisor.note_shared_memory()
        for name, process in self.supervisor.processes.items():
            used = usage(process.identity) if name in NODES else None
            if used is not None:
                key = name, process.identity
                self.growth.setdefault(key, Growth(process.started)).add(now, used)

    def latest(self) -> dict[str, Growth]:
        """Of each node the process that was started last, by name."""
        return {name: growth for (name, _), growth in self.growth.items()}

    def close(self) -> None:
        """Hear nothing any more."""
        self._executor.shutdown()
        for node in self._nodes:
            node.destroy_node()


@contextmanager
def watched_nodes(
    configuration: Configuration, output: Path, domain: int | None
) -> Iterator[WatchedNodes]:
    """A place for nodes, which all end with it.

    Args:
        configuration: What they will fly.
        output: Existing folder for what they print.
        domain: ROS domain; None takes one that no other launch uses.
    """
    compile_flight(configuration.controller)  # no other solver is tried
    log = (output / LOG).open("w", encoding="utf-8")
    with signals() as received, log, supervised(Console(file=log), domain) as supervisor:
        nodes = WatchedNodes(supervisor, received)
        try:
            yield nodes
        finally:
            nodes.close()
