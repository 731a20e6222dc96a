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

"""Hours of flight without faults: is the orbit held all the while, does any process grow."""

from __future__ import annotations

import contextlib
import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rich.console import Console

from uav_tracking_mpc.control.guidance import compile_flight
from uav_tracking_mpc.launch.flight import signals
from uav_tracking_mpc.launch.supervisor import LaunchError, Supervisor, supervised
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.observer import seconds, vector
from uav_tracking_mpc.studies.faults.resources import Growth, ResourceWatch, Usage

SPEED = 20.0  # -, simulated over wall time, as far as the machine keeps up
TOLERANCE = 10.0  # m, greatest range error
SETTLING = 180.0  # s of simulated time to fly onto the orbit
SAMPLE_PERIOD = 1.0  # s of wall time
REPORT_PERIOD = 20.0  # s of wall time
STALL_LIMIT = 60.0  # s of wall time in which simulated time must move on
QUEUE = 1000  # messages that may wait


class SoakObserver(Node):
    """Hears states, targets and commands.

    Args:
        wanted: Range of the orbit [m].
        options: As of rclpy's Node.

    Attributes:
        time: Of the latest state, simulated [s].
        settled: Greatest |r - r_d| [m] after the settling time, and when it was [s].
        range_error: The latest r - r_d [m].
        commands: How many came.
        longest_gap: Greatest time between the states of two commands [s].
    """

    def __init__(self, wanted: float, **options: Any) -> None:
        super().__init__("soak_observer", **options)
        self._wanted = wanted
        self._target: np.ndarray | None = None
        self._commanded = math.nan
        self.time, self.range_error = 0.0, math.nan
        self.settled = (0.0, 0.0)
        self.commands, self.longest_gap = 0, 0.0
        FollowingSubscription(self, ODOMETRY, self._on_state, QUEUE)
        FollowingSubscription(self, TARGET, self._on_target, QUEUE)
        FollowingSubscription(self, COMMAND, self._on_command, QUEUE)

    def _on_state(self, message: Any) -> None:
        self.time = seconds(message.header.stamp)
        if self._target is None:
            return
        offset = vector(message.pose.pose.position) - self._target
        self.range_error = float(np.linalg.norm(offset)) - self._wanted
        if self.time > SETTLING and not abs(self.range_error) <= self.settled[0]:
            self.settled = abs(self.range_error), self.time

    def _on_target(self, message: Any) -> None:
        self._target = vector(message.point)

    def _on_command(self, message: Any) -> None:
        stamp = seconds(message.header.stamp)
        self.commands += 1
        if stamp > SETTLING:
            self.longest_gap = max(self.longest_gap, stamp - self._commanded)
        self._commanded = stamp


def soak(
    configuration: Configuration,
    hours: float,
    output: Path,
    console: Console,
    domain: int | None = None,
) -> dict[str, Any]:
    """Fly for hours of simulated time, at the speed of the mission.

    Args:
        configuration: What to fly.
        hours: Simulated [h].
        output: Existing folder for the nodes' output.
        console: Where progress goes.
        domain: ROS domain; None takes one that no other launch uses.

    Returns:
        What ``--json`` prints.

    Raises:
        LaunchError: A node died, or time stood still.
        KeyboardInterrupt: A signal came.
    """
    compile_flight(configuration.controller)  # what is measured is not another solver
    resources = ResourceWatch()
    with contextlib.ExitStack() as stack:
        received = stack.enter_context(signals())
        log = stack.enter_context((output / "nodes.log").open("w", encoding="utf-8"))
        supervisor = stack.enter_context(supervised(Console(file=log), domain))
        observer, executor = SoakObserver(configuration.controller.range), EventsExecutor()
        executor.add_node(observer)
        stack.callback(observer.destroy_node)
        stack.callback(executor.shutdown)
        supervisor.start_flight(configuration, configuration.mission.speed)
        begin, flown = _watch(
            observer, executor, supervisor, resources, 3600.0 * hours, received, console
        )
        wall = time.monotonic() - begin
    worst, when = observer.settled
    nodes = {name: _told(growth) for name, growth in resources.latest().items()}
    return {
        "config": configuration.name,
        "simulated_hours": observer.time / 3600.0,
        "wall_minutes": wall / 60.0,
        "speed": flown / wall,
        "control_rate_hz": observer.commands / observer.time,
        "control_rate_wanted_hz": configuration.controller.control_rate,
        "longest_gap_s": observer.longest_gap,
        "max_range_error_m": worst,
        "max_range_error_at_s": when,
        "rss_growth_percent": max(node["rss_growth_percent"] for node in nodes.values()),
        "nodes": nodes,
        "violations": (worst > TOLERANCE) + sum(bool(node["complaint"]) for node in nodes.values()),
    }


def _watch(
    observer: SoakObserver,
    executor: EventsExecutor,
    supervisor: Supervisor,
    resources: ResourceWatch,
    duration: float,
    received: list[int],
    console: Console,
) -> tuple[float, float]:
    """Fly to the end; when time began to pass, by a steady clock, and for how long it did [s]."""
    began = sampled = told = moved = time.monotonic()
    before = 0.0
    while observer.time < duration:
        executor.spin_once(timeout_sec=0.1)
        if received:
            raise KeyboardInterrupt
        now = time.monotonic()
        if before == 0.0 and observer.time > 0.0:
            began = moved = now
            before = observer.time
        if now - sampled < SAMPLE_PERIOD:
            continue
        sampled = now
        if observer.time > before:
            moved, before = now, observer.time
        if now - moved > STALL_LIMIT:
            raise LaunchError(f"simulated time stood still for {STALL_LIMIT:g} s")
        supervisor.check()
        supervisor.note_shared_memory()
        resources.sample(now, supervisor.processes.values())
        if now - told > REPORT_PERIOD:
            told = now
            console.print(
                f"{observer.time / 3600.0:6.3f} h simulated, {observer.time / (now - began):5.1f} "
                f"times real time, r - r_d {observer.range_error:+7.3f} m, at most "
                f"{observer.settled[0]:.3f} m, {observer.commands} commands",
                highlight=False,
            )
    return began, observer.time


def _told(growth: Growth) -> dict[str, Any]:
    """How a process grew after its warm-up."""
    samples = growth.samples
    half = growth.second_half()
    first, last = (samples[0][1], samples[-1][1]) if samples else (Usage(0, 0, 0),) * 2
    return {
        "rss_mb": last.rss / 1e6,
        "rss_growth_percent": growth.rss_percent(),
        "rss_growth_second_half_percent": half.rss_percent(),
        "handles": [first.handles, last.handles],
        "threads": [first.threads, last.threads],
        "complaint": half.complaint(),
    }
