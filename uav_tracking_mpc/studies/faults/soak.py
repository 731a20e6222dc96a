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

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node
from rich.console import Console

from uav_tracking_mpc.launch.supervisor import LaunchError
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.report.atomic_write import json_text
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.observer import seconds, vector
from uav_tracking_mpc.studies.faults.resources import Growth, Usage
from uav_tracking_mpc.studies.faults.watched_nodes import WatchedNodes, watched_nodes
from uav_tracking_mpc.studies.study import Study

SPEED = 20.0  # -, simulated over wall time, as far as the machine keeps up
TOLERANCE = 10.0  # m, greatest range error
SETTLING = 180.0  # s of simulated time to fly onto the orbit
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
) -> Study:
    """Fly for hours of simulated time, at the speed of the mission.

    Args:
        configuration: What to fly.
        hours: Simulated [h].
        output: Existing folder for the nodes' output.
        console: Where progress goes.
        domain: ROS domain; None takes one that no other launch uses.

    Raises:
        LaunchError: A node died, or time stood still.
        KeyboardInterrupt: A signal came.
    """
    with watched_nodes(configuration, output, domain) as flight:
        observer = SoakObserver(configuration.controller.range)
        flight.hear(observer)
        flight.supervisor.start_flight(configuration, configuration.mission.speed)
        begin = _watch(flight, observer, 3600.0 * hours, console)
        wall, flown = time.monotonic() - begin, observer.time
    worst, when = observer.settled
    nodes = {name: _told(growth) for name, growth in flight.latest().items()}
    violations = (worst > TOLERANCE) + sum(bool(node["complaint"]) for node in nodes.values())
    content = {
        "config": configuration.name,
        "simulated_hours": flown / 3600.0,
        "wall_minutes": wall / 60.0,
        "speed": flown / wall,
        "control_rate_hz": observer.commands / flown,
        "control_rate_wanted_hz": configuration.controller.control_rate,
        "longest_gap_s": observer.longest_gap,
        "max_range_error_m": worst,
        "max_range_error_at_s": when,
        "rss_growth_percent": max(node["rss_growth_percent"] for node in nodes.values()),
        "nodes": nodes,
        "violations": violations,
    }
    return Study("soak", content, [json_text(content)], good=not violations)


def _watch(
    flight: WatchedNodes, observer: SoakObserver, duration: float, console: Console
) -> float:
    """Fly to the end; when time began to pass, by a steady clock [s]."""
    began = told = moved = time.monotonic()
    before = 0.0
    for now in flight.spin():
        if observer.time > before:
            began = now if before == 0.0 else began
            moved, before = now, observer.time
        if observer.time >= duration:
            break
        if now - moved > STALL_LIMIT:
            raise LaunchError(f"simulated time stood still for {STALL_LIMIT:g} s")
        flight.supervisor.check()
        if now - told > REPORT_PERIOD:
            told = now
            console.print(
                f"{observer.time / 3600.0:6.3f} h simulated, {observer.time / (now - began):5.1f} "
                f"times real time, r - r_d {observer.range_error:+7.3f} m, at most "
                f"{observer.settled[0]:.3f} m, {observer.commands} commands",
                highlight=False,
            )
    return began


def _told(growth: Growth) -> dict[str, Any]:
    """How a process grew after its warm-up."""
    half, used = growth.second_half(), [used for _, used in growth.samples] or [Usage(0, 0, 0)]
    return {
        "rss_mb": used[-1].rss / 1e6,
        "rss_growth_percent": growth.rss_percent(),
        "rss_growth_second_half_percent": half.rss_percent(),
        "handles": [used[0].handles, used[-1].handles],
        "threads": [used[0].threads, used[-1].threads],
        "complaint": half.complaint(),
    }
