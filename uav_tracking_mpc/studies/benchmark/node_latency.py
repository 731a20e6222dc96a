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

"""Latency of three real nodes, from a state to its command, and with a page beside them.

Round trips are timed in the simulator's process, beside those of an echo of the same messages. The
page shows the flight to a client that reads it and renders nothing. First come the programs of
these processes, then what starts them and counts.
"""

from __future__ import annotations

import json
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node
from rich.console import Console

from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.control.guidance import compile_flight
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.launch.supervisor import LaunchError, Supervisor, supervised
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, set_stamp
from uav_tracking_mpc.nodes.messages.wires import CommandWire, command_stamp
from uav_tracking_mpc.nodes.ros.endpoints import listen, publish
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.report.atomic_write import write_atomically
from uav_tracking_mpc.report.metrics import microseconds
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.resources import Usage, usage
from uav_tracking_mpc.studies.study import Say, Study

ECHO_ODOMETRY, ECHO_AIR_VELOCITY, ECHO_COMMAND = (
    replace(topic, name=f"echo/{topic.name}") for topic in (ODOMETRY, AIR_VELOCITY, COMMAND)
)


def timed_controller() -> Node:
    """The controller, which also answers the echo's states: with one and the same plan."""
    from uav_tracking_mpc.nodes.nmpc_controller import NmpcController

    node, wire = NmpcController(), CommandWire()
    segments, step = node.parameters.horizon, node.parameters.horizon_step
    plan = np.zeros((segments, 3))
    path = PlannedPath(np.zeros((segments + 1, 6)), np.zeros((segments + 1, 3)))
    commands = publish(node, ECHO_COMMAND)

    def answer(message: Any) -> None:
        commands.publish(wire.write(nanoseconds(message.header.stamp), plan, step, path))

    listen(node, ECHO_ODOMETRY, answer)
    listen(node, ECHO_AIR_VELOCITY, lambda message: None)
    return node


class RoundTrips:
    """Times from a state's publication to the arrival of the command that answers it.

    Attributes:
        times: When each began, by ``time.perf_counter``, and how long it took, in [s].
    """

    def __init__(self) -> None:
        self.times: list[tuple[float, float]] = []
        self._sent = (0, 0.0)

    def send(self, stamp: int) -> None:
        """Note that a state with this stamp in [ns] is about to be published."""
        self._sent = stamp, time.perf_counter()

    def arrive(self, stamp: int) -> None:
        """Note that a command has come; one that answers an older state does not count."""
        sent, begin = self._sent
        if stamp == sent:
            self.times.append((begin, time.perf_counter() - begin))


WARM_UP = 10.0  # s of flight that do not count; the file is there afterwards


class TimedSimulator(UavSimulator):
    """Writes the round trips of its states and of the echo to a file when it ends.

    The echo's states are sent half a period after the simulator's own.

    Args:
        result: The file.
    """

    def __init__(self, result: str) -> None:
        self.trips, self.echo = RoundTrips(), RoundTrips()
        super().__init__()
        self._result = Path(result)
        self._flown_from: int | None = None  # stamp of the first command [ns]
        self._echoes = publish(self, ECHO_ODOMETRY), publish(self, ECHO_AIR_VELOCITY)
        listen(self, ECHO_COMMAND, lambda data: self.echo.arrive(command_stamp(data)), raw=True)
        self._echo_timer = self.create_timer(0.5 / self.parameters.state_rate, self._send_echo)
        self._echo_timer.cancel()
        publish_state = self._state_publisher.publisher.publish

        def noted(message: Any) -> None:
            self.trips.send(nanoseconds(message.header.stamp))
            publish_state(message)

        self._state_publisher.publisher.publish = noted  # type: ignore[method-assign]

    def _publish(self, stamp: int, seen: Measurement, state: bool = True) -> None:
        super()._publish(stamp, seen, state)
        self._echo_timer.reset()

    def _send_echo(self) -> None:
        self._echo_timer.cancel()
        stamp = self.get_clock().now().nanoseconds
        self.echo.send(stamp)
        for publisher, message in zip(
            self._echoes, (self._odometry, self._air_velocity), strict=True
        ):
            set_stamp(message.header.stamp, stamp)
            publisher.publish(message)

    def _on_command(self, data: bytes) -> None:
        stamp = command_stamp(data)
        self.trips.arrive(stamp)
        super()._on_command(data)
        if self._flown_from is None:
            self._flown_from = stamp
        elif stamp - self._flown_from > WARM_UP * 1e9 and not self._result.exists():
            self._result.touch()
            self.trips.times.clear()
            self.echo.times.clear()

    def finish(self) -> None:
        """Write the times in [s]."""
        super().finish()
        times = {"controller": self.trips.times, "echo": self.echo.times}
        self._result.write_text(json.dumps(times), encoding="utf-8")


COUNT_PERIOD = 0.2  # s between writes of the count


def page(address: str) -> None:
    """Serve a page until SIGTERM.

    Args:
        address: File that the page's address is written to.
    """
    from uav_tracking_mpc.view.live_source import LiveSource
    from uav_tracking_mpc.view.page import Page

    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    shown = Page(LiveSource())
    write_atomically(Path(address), shown.address.encode())
    try:
        shown.serve(ended.is_set)
    finally:
        shown.close()


def page_reader(address: str, counted: str) -> None:
    """Read a page until SIGTERM.

    Args:
        address: File that holds the page's address.
        counted: File that the number of messages is written to.
    """
    import viser
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    place = Path(address).read_text(encoding="utf-8").replace("http", "ws", 1)
    count, due = 0, 0.0
    # viser takes clients of its own version alone.
    spoken = [Subprotocol(f"viser-v{viser.__version__}")]
    with connect(place, subprotocols=spoken, max_size=None, compression=None) as connection:
        for _ in connection:
            count += 1
            if (now := time.monotonic()) >= due:
                due = now + COUNT_PERIOD
                write_atomically(Path(counted), str(count).encode())


PROCESSES = "uav_tracking_mpc.studies.benchmark.node_latency"  # this file, run as a program
START_LIMIT = 180.0  # s until the warm-up is flown, with the solver's compilation
LOOK_PERIOD = 0.2  # s
TURNS = 3  # with the page, and as many without
SETTLING = 5.0  # s after a page was opened or closed that do not count
CONTROLLER, SIMULATOR = "nmpc_controller", "uav_simulator"
PAGE, READER = "page", "page_reader"


# A time that passed: ``begin`` and ``end`` by the clock of the round trips in [s], and what a
# process used in it: ``cpu``, the share of a core, ``memory`` at the end and ``growth`` in [MB].
_Span = dict[str, float]


class _TimedNodes:
    """Aircraft with three nodes each, which have flown their warm-up.

    Raises:
        LaunchError: A node died, or nothing flew.
    """

    def __init__(
        self, supervisor: Supervisor, folder: str, configuration: Configuration, count: int = 1
    ) -> None:
        self._supervisor, self._folder = supervisor, Path(folder)
        compile_flight(configuration.controller)  # what is measured is not another solver
        parameters = self._folder / "flight.yaml"
        parameters.write_text(configuration.yaml(), encoding="utf-8")
        spaces = [""] if count == 1 else [f"uav{k + 1}" for k in range(count)]
        self._results = [self._folder / f"round_trips{space}.json" for space in spaces]
        for space, result in zip(spaces, self._results, strict=True):
            given = ["--ros-args", "--params-file", str(parameters), "--log-level", "WARN"]
            given += ["-r", f"__ns:=/{space}"] if space else []
            timed = [str(result), *given, "-p", "start_on_command:=true"]
            for name, module, arguments in (
                (CONTROLLER, PROCESSES, [CONTROLLER, *given]),
                ("target_publisher", "uav_tracking_mpc.nodes.target_publisher", given),
                (SIMULATOR, PROCESSES, [SIMULATOR, *timed]),
            ):
                self._supervisor.start(f"{space} {name}".strip(), module, arguments)
        for result in self._results:
            self._appears(result, "the nodes have not flown")

    def wait(self, limit: float, done: Callable[[], bool] = lambda: False) -> None:
        """Wait, watching the processes, for a time in [s] or until something is done."""
        end = time.monotonic() + limit
        while time.monotonic() < end and not done():
            self._supervisor.check()
            time.sleep(min(LOOK_PERIOD, max(end - time.monotonic(), 0.0)))

    def _appears(self, file: Path, words: str) -> None:
        self.wait(START_LIMIT, file.exists)
        if not file.exists():
            raise LaunchError(f"{words} within {START_LIMIT:g} s")

    def _used(self, process: str) -> Usage:
        used = usage(self._supervisor.processes[process].identity)
        if used is None:
            raise LaunchError(f"{process} has ended")
        return used

    def span(self, duration: float, process: str) -> _Span:
        """Let time pass."""
        before, begin = self._used(process), time.perf_counter()
        self.wait(duration)
        end, after = time.perf_counter(), self._used(process)
        return {
            "begin": begin,
            "end": end,
            "cpu": (after.cpu - before.cpu) / (end - begin),
            "memory": after.rss / 2**20,
            "growth": (after.rss - before.rss) / 2**20,
        }

    def watched_span(self, duration: float) -> _Span:
        """Let time pass with a page open; also how many ``messages`` a second its client read."""
        address, count = self._folder / "address", self._folder / "messages"
        for name, file, arguments, words in (
            (PAGE, address, [PAGE, str(address)], "the page is not there"),
            (READER, count, [READER, str(address), str(count)], "the page has sent nothing"),
        ):
            file.unlink(missing_ok=True)
            self._supervisor.start(name, PROCESSES, arguments)
            self._appears(file, words)
        self.wait(SETTLING)
        read = int(count.read_text(encoding="utf-8"))
        span = self.span(duration, PAGE)
        messages = int(count.read_text(encoding="utf-8")) - read
        for name in (READER, PAGE):
            self._supervisor.processes.pop(name).stop(signal.SIGTERM)
        return {**span, "messages": messages / (span["end"] - span["begin"])}

    def end(self) -> list[dict[str, list[list[float]]]]:
        """End the nodes; what each simulator wrote."""
        self._supervisor.end()
        return [json.loads(result.read_text(encoding="utf-8")) for result in self._results]


def _summary(trips: Sequence[Sequence[float]]) -> dict[str, Any]:
    """Median, p99, max in [us] and count of round trips."""
    if not trips:
        raise LaunchError("no state was answered")
    micros = microseconds(np.array([duration for _, duration in trips]))
    return {
        **{name.removesuffix("_us"): each for name, each in micros.items()},
        "count": len(trips),
    }


def _line(name: str, row: dict[str, float]) -> str:
    return (
        f"  {name:12s} median {row['median']:6.0f} us   p99 {row['p99']:6.0f} us   "
        f"max {row['max']:6.0f} us   of {row['count']}"
    )


def node_latency(configuration: Configuration, duration: float, progress: Say) -> Study:
    """Fly in wall time and measure.

    Args:
        configuration: What is flown, at its rates.
        duration: In [s], after a warm-up.
        progress: Called with words about what begins.

    Returns:
        Its content: ``state_to_command_us`` and ``echo_us`` {median, p99, max, count}: from before
        a state is published in the simulator's process to the arrival of its command there;
        ``ratio`` of their medians; ``controller_cpu_share`` of a core, the echo's answers included;
        the configuration's name, and the rates in [Hz].

    Raises:
        LaunchError: A node died, or nothing flew.
    """
    progress("nodes: warm-up")
    with tempfile.TemporaryDirectory() as folder, supervised(Console(stderr=True)) as supervisor:
        nodes = _TimedNodes(supervisor, folder, configuration)
        progress(f"nodes: {duration:g} s of flight")
        span = nodes.span(duration, CONTROLLER)
        (trips,) = nodes.end()
    controller, echo = (_summary(trips[name]) for name in ("controller", "echo"))
    rate, ratio = configuration.controller.control_rate, controller["median"] / echo["median"]
    content = {
        "config": configuration.name,
        "state_rate_hz": configuration.simulator.state_rate,
        "control_rate_hz": rate,
        "state_to_command_us": controller,
        "echo_us": echo,
        "ratio": ratio,
        "controller_cpu_share": span["cpu"],
    }
    words = [
        f"{configuration.name}, three nodes, {rate:g} commands a second, published state to "
        "received command:",
        _line("controller", controller),
        _line("echo", echo),
        f"  ratio {ratio:.2f}; the controller's process takes {100.0 * span['cpu']:.0f} % of a "
        "core",
    ]
    return Study("nodes", content, words, "saved in {}")


def watched_latency(
    configuration: Configuration,
    aircraft: Sequence[int],
    duration: float,
    progress: Say,
    turns: int = TURNS,
) -> Study:
    """Fly in wall time, open and close a page, and measure.

    The page draws twenty times a second all that is flown; a client of its own process reads what
    it sends and renders nothing.

    Args:
        configuration: What each aircraft flies, at its rates.
        aircraft: How many, one flight each.
        duration: Of a turn in [s].
        progress: Called with words about what begins.
        turns: With the page, and as many without.

    Returns:
        Its content: ``view``, of each flight ``aircraft``; ``without_us`` and ``with_us`` {median,
        p99, max, count}, from before a state is published to the arrival of its command;
        ``median_ratio`` and ``p99_ratio`` of these; of the page's process ``page_cpu_share`` of a
        core, ``page_memory_mb`` at the end and ``page_growth_mb`` over its last turn, ``turn_s``
        long; ``messages_hz`` that its client read.

    Raises:
        LaunchError: A process died, nothing flew, or there is no page.
    """
    flights = [_watched(configuration, count, duration, progress, turns) for count in aircraft]
    words = [
        line
        for flight in flights
        for line in (
            f"{flight['aircraft']} aircraft, published state to received command:",
            _line("without page", flight["without_us"]),
            _line("with page", flight["with_us"]),
            f"  ratio of medians {flight['median_ratio']:.3f}, of p99 {flight['p99_ratio']:.3f}",
            f"  the page's process takes {100.0 * flight['page_cpu_share']:.0f} % of a core and "
            f"{flight['page_memory_mb']:.0f} MB, {flight['page_growth_mb']:.1f} MB more than "
            f"{flight['turn_s']:g} s before; its client read {flight['messages_hz']:.0f} messages "
            "a second",
        )
    ]
    return Study("nodes", {"view": flights}, words, "saved in {}")


def _watched(
    configuration: Configuration, count: int, duration: float, progress: Say, turns: int
) -> dict[str, Any]:
    spans: dict[str, list[_Span]] = {"without": [], "with": []}
    progress(f"{count} aircraft: warm-up")
    with tempfile.TemporaryDirectory() as folder, supervised(Console(stderr=True)) as supervisor:
        nodes = _TimedNodes(supervisor, folder, configuration, count)
        controller = CONTROLLER if count == 1 else f"uav1 {CONTROLLER}"
        for turn in range(turns):
            progress(f"{count} aircraft: turn {turn + 1} of {turns}, without a page")
            nodes.wait(SETTLING)
            spans["without"].append(nodes.span(duration, controller))
            progress(f"{count} aircraft: turn {turn + 1} of {turns}, with a page")
            spans["with"].append(nodes.watched_span(duration))
        flown = [trip for trips in nodes.end() for trip in trips["controller"]]
    without, watched = (
        _summary([t for t in flown if any(each["begin"] <= t[0] <= each["end"] for each in found)])
        for found in spans.values()
    )
    pages = spans["with"]
    return {
        "aircraft": count,
        "turn_s": duration,
        "without_us": without,
        "with_us": watched,
        "median_ratio": watched["median"] / without["median"],
        "p99_ratio": watched["p99"] / without["p99"],
        "page_cpu_share": sum(page["cpu"] for page in pages) / turns,
        "page_memory_mb": pages[-1]["memory"],
        "page_growth_mb": pages[-1]["growth"],
        "messages_hz": sum(page["messages"] for page in pages) / turns,
    }


if __name__ == "__main__":
    name, *given = sys.argv[1:]
    programs = {
        PAGE: lambda: page(*given),
        READER: lambda: page_reader(*given),
        CONTROLLER: lambda: run(name, timed_controller, given),
        SIMULATOR: lambda: run(name, lambda: TimedSimulator(given[0]), given[1:]),
    }
    sys.exit(programs[name]())
