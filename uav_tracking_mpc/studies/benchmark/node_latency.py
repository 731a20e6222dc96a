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

"""Three real nodes timed from a state to its command: beside an echo, or with a page open."""

from __future__ import annotations

import json
import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from uav_tracking_mpc.control.guidance import compile_flight
from uav_tracking_mpc.launch.supervisor import LaunchError, Supervisor, supervised
from uav_tracking_mpc.report.metrics import microseconds
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.faults.resources import Usage, usage
from uav_tracking_mpc.studies.study import Study

PROCESSES = "uav_tracking_mpc.studies.benchmark.timed_processes"
START_LIMIT = 180.0  # s until the warm-up is flown, with the solver's compilation
LOOK_PERIOD = 0.2  # s
TURNS = 3  # with the page, and as many without
SETTLING = 5.0  # s after a page was opened or closed that do not count
CONTROLLER, PAGE, READER = "nmpc_controller", "page", "page_reader"

Progress = Callable[[str], None]


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
                ("uav_simulator", PROCESSES, ["uav_simulator", *timed]),
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


def node_latency(configuration: Configuration, duration: float, progress: Progress) -> Study:
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
    progress: Progress,
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
    configuration: Configuration, count: int, duration: float, progress: Progress, turns: int
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
