"""Hours of flight without faults: is the orbit held all the while, does any process grow."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rich.console import Console

from uav_tracking_mpc.launch.launcher import NODES, LaunchError, node_arguments
from uav_tracking_mpc.launch.node_process import NodeProcess
from uav_tracking_mpc.launch.shared_memory import SharedMemoryFiles
from uav_tracking_mpc.nodes.topics import COMMAND, ODOMETRY, TARGET
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.resources import Growth, Usage, usage

SPEED = 20.0  # simulated over wall time, as far as the machine keeps up
TOLERANCE = 10.0  # m of range error
SETTLING = 180.0  # s of simulated time to fly onto the orbit
SAMPLE_PERIOD = 1.0  # s of wall time
REPORT_PERIOD = 20.0  # s of wall time
STALL_LIMIT = 60.0  # s of wall time in which simulated time must move on
QUEUE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)


class SoakObserver(Node):
    """Hears states, targets and commands.

    Args:
        wanted: Range of the orbit [m].

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
        self.create_subscription(ODOMETRY.type, ODOMETRY.name, self._on_state, QUEUE)
        self.create_subscription(TARGET.type, TARGET.name, self._on_target, QUEUE)
        self.create_subscription(COMMAND.type, COMMAND.name, self._on_command, QUEUE)

    def _on_state(self, message: Any) -> None:
        self.time = _seconds(message)
        if self._target is None:
            return
        point = message.pose.pose.position
        offset = np.array([point.x, point.y, point.z]) - self._target
        self.range_error = float(np.linalg.norm(offset)) - self._wanted
        if self.time > SETTLING and not abs(self.range_error) <= self.settled[0]:
            self.settled = abs(self.range_error), self.time

    def _on_target(self, message: Any) -> None:
        self._target = np.array([message.point.x, message.point.y, message.point.z])

    def _on_command(self, message: Any) -> None:
        stamp = _seconds(message)
        self.commands += 1
        if stamp > SETTLING:
            self.longest_gap = max(self.longest_gap, stamp - self._commanded)
        self._commanded = stamp


def _seconds(message: Any) -> float:
    return float(message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec)


def soak(configuration: Configuration, hours: float, output: Path, console: Console) -> Any:
    """Fly for hours of simulated time, at the speed of the mission.

    Args:
        configuration: What to fly.
        hours: Simulated.
        output: Existing folder for the nodes' output.
        console: Where progress goes.

    Returns:
        What ``--json`` prints.

    Raises:
        LaunchError: A node died, or time stood still.
    """
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    files = SharedMemoryFiles()
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        log = stack.enter_context((output / "nodes.log").open("w", encoding="utf-8"))
        stack.callback(files.remove_orphans)
        stack.callback(rclpy.try_shutdown)
        observer, executor = SoakObserver(configuration.controller.range), EventsExecutor()
        executor.add_node(observer)
        parameters = Path(folder) / "parameters.yaml"
        parameters.write_text(configuration.yaml(), encoding="utf-8")
        crew: dict[str, NodeProcess] = {}
        growth: dict[str, Growth] = {}
        for name in NODES:
            arguments = node_arguments(name, parameters, configuration)
            crew[name] = NodeProcess(name, arguments, Console(file=log))
            growth[name] = Growth(time.monotonic())
            stack.callback(crew[name].stop, signal.SIGTERM)
        begin, flown = _watch(observer, executor, crew, growth, 3600.0 * hours, console)
        files.note([os.getpid(), *(process.identity for process in crew.values())])
        executor.shutdown()
        observer.destroy_node()
    wall = time.monotonic() - begin
    worst, when = observer.settled
    nodes = {name: _told(samples) for name, samples in growth.items()}
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
    crew: dict[str, NodeProcess],
    growth: dict[str, Growth],
    duration: float,
    console: Console,
) -> tuple[float, float]:
    """Fly to the end; when time began to pass, by a steady clock, and for how long it did [s]."""
    began = sampled = told = moved = time.monotonic()
    before = 0.0
    while observer.time < duration:
        executor.spin_once(timeout_sec=0.1)
        now = time.monotonic()
        if before == 0.0 or now - sampled < SAMPLE_PERIOD:
            if before == 0.0 and observer.time > 0.0:
                began, before = now, observer.time
            if now - moved > STALL_LIMIT:
                raise LaunchError(f"simulated time stood still for {STALL_LIMIT:g} s")
            continue
        sampled = now
        if observer.time > before:
            moved, before = now, observer.time
        for name, process in crew.items():
            sample = usage(process.identity)
            if process.exit_code is not None:
                raise LaunchError(f"{name} died with exit code {process.exit_code}")
            if sample is not None:
                growth[name].add(now, sample)
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
    half = Growth(-math.inf)
    half.samples = samples[len(samples) // 2 :]
    first, last = (samples[0][1], samples[-1][1]) if samples else (Usage(0, 0, 0),) * 2
    return {
        "rss_mb": last.rss / 1e6,
        "rss_growth_percent": _percent(growth),
        "rss_growth_second_half_percent": _percent(half),
        "handles": [first.handles, last.handles],
        "threads": [first.threads, last.threads],
        "complaint": half.complaint(),
    }


def _percent(growth: Growth) -> float:
    """Memory over the time that was watched, by least squares."""
    return (growth.rss_percent_per_hour() or 0.0) * growth.span / 3600.0
