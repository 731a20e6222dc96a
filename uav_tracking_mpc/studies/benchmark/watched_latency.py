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

"""What a page costs a flight: latency in turns without and with one that is watched."""

from __future__ import annotations

import json
import signal
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from uav_tracking_mpc.launch.supervisor import LaunchError, Supervisor, supervised
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.benchmark.timed_nodes import (
    ROOM,
    START_LIMIT,
    processor_time,
    resident_memory,
    start_timed_nodes,
    summary,
    wait,
)

TURNS = 3  # with the page, and as many without
SETTLING = 5.0  # s after a page was opened or closed that do not count
OPEN_LIMIT = START_LIMIT  # s for a page to be there
PAGE, READER = "page", "page_reader"


def watched_latency(
    configuration: Configuration,
    aircraft: Sequence[int],
    duration: float,
    progress: Callable[[str], None],
    turns: int = TURNS,
) -> list[dict[str, Any]]:
    """Fly in wall time, open and close a page, and measure.

    The page draws twenty times a second all that is flown; a client of its own process reads what
    it sends and renders nothing.

    Args:
        configuration: What each aircraft flies, at its rates.
        aircraft: How many, one flight each.
        duration: Of a turn in [s].
        progress: Told what goes on.
        turns: With the page, and as many without.

    Returns:
        Of each flight ``aircraft``; ``without_us`` and ``with_us`` {median, p99, max, count}, from
        before a state is published to the arrival of its command; ``median_ratio`` and
        ``p99_ratio`` of these; of the page's process ``page_cpu_share`` of a core,
        ``page_memory_mb`` at the end and ``page_growth_mb`` over its last turn, ``turn_s`` long;
        ``messages_hz`` that its client read.

    Raises:
        LaunchError: A process died, nothing flew, or there is no page.
    """
    return [_flown(configuration, count, duration, progress, turns) for count in aircraft]


def in_words(flights: Sequence[dict[str, Any]]) -> list[str]:
    """Lines of text.

    Args:
        flights: Of :func:`watched_latency`.
    """
    lines = []
    for flight in flights:
        lines.append(f"{flight['aircraft']} aircraft, published state to received command:")
        for name, key in (("without page", "without_us"), ("with page", "with_us")):
            row = flight[key]
            lines.append(
                f"  {name:12s} median {row['median']:6.0f} us   p99 {row['p99']:6.0f} us   "
                f"of {row['count']}"
            )
        lines += [
            f"  ratio of medians {flight['median_ratio']:.3f}, of p99 {flight['p99_ratio']:.3f}",
            f"  the page's process takes {100.0 * flight['page_cpu_share']:.0f} % of a core and "
            f"{flight['page_memory_mb']:.0f} MB, {flight['page_growth_mb']:.1f} MB more than "
            f"{flight['turn_s']:g} s before; its client read {flight['messages_hz']:.0f} messages "
            "a second",
        ]
    return lines


def _flown(
    configuration: Configuration,
    count: int,
    duration: float,
    progress: Callable[[str], None],
    turns: int,
) -> dict[str, Any]:
    spaces = ("",) if count == 1 else tuple(f"uav{k + 1}" for k in range(count))
    spans: dict[str, list[tuple[float, float]]] = {"without": [], "with": []}
    pages: list[dict[str, float]] = []
    with tempfile.TemporaryDirectory() as folder, supervised(Console(stderr=True)) as supervisor:
        progress(f"{count} aircraft: warm-up")
        results = start_timed_nodes(supervisor, Path(folder), configuration, spaces)
        for turn in range(turns):
            progress(f"{count} aircraft: turn {turn + 1} of {turns}, without a page")
            wait(supervisor, SETTLING)
            spans["without"].append(_span(supervisor, duration))
            progress(f"{count} aircraft: turn {turn + 1} of {turns}, with a page")
            spans_with, page = _watched(supervisor, Path(folder), duration)
            spans["with"].append(spans_with)
            pages.append(page)
        supervisor.end()
        trips = [json.loads(result.read_text(encoding="utf-8")) for result in results]
    found = {name: summary(_inside(trips, windows)) for name, windows in spans.items()}
    without, watched = found["without"], found["with"]
    return {
        "aircraft": count,
        "turn_s": duration,
        "without_us": without,
        "with_us": watched,
        "median_ratio": watched["median"] / without["median"],
        "p99_ratio": watched["p99"] / without["p99"],
        "page_cpu_share": sum(page["cpu"] for page in pages) / len(pages),
        "page_memory_mb": pages[-1]["memory"],
        "page_growth_mb": pages[-1]["growth"],
        "messages_hz": sum(page["messages"] for page in pages) / len(pages),
    }


def _watched(
    supervisor: Supervisor, folder: Path, duration: float
) -> tuple[tuple[float, float], dict[str, float]]:
    """When a turn with a page began and ended, and what the page took meanwhile."""
    address, count = folder / "address", folder / "messages"
    for path in (address, count):
        path.unlink(missing_ok=True)
    supervisor.start(PAGE, f"{ROOM}.watched_page", [str(address)])
    wait(supervisor, OPEN_LIMIT, address.exists)
    if not address.exists():
        raise LaunchError(f"the page is not there within {OPEN_LIMIT:g} s")
    supervisor.start(READER, f"{ROOM}.page_reader", [str(address), str(count)])
    wait(supervisor, OPEN_LIMIT, count.exists)
    if not count.exists():
        raise LaunchError(f"the page has sent nothing within {OPEN_LIMIT:g} s")
    wait(supervisor, SETTLING)
    process = supervisor.processes[PAGE].identity
    used, held, read = processor_time(process), resident_memory(process), _number(count)
    begin, end = _span(supervisor, duration)
    page = {
        "cpu": (processor_time(process) - used) / (end - begin),
        "memory": resident_memory(process),
        "growth": resident_memory(process) - held,
        "messages": (_number(count) - read) / (end - begin),
    }
    for name in (READER, PAGE):
        supervisor.processes.pop(name).stop(signal.SIGTERM)
    return (begin, end), page


def _span(supervisor: Supervisor, duration: float) -> tuple[float, float]:
    """Let time pass; when that began and ended, by the clock of the round trips in [s]."""
    begin = time.perf_counter()
    wait(supervisor, duration)
    return begin, time.perf_counter()


def _inside(
    trips: Sequence[dict[str, list[float]]], windows: Sequence[tuple[float, float]]
) -> list[float]:
    """Round trips of all aircraft that began in one of the windows, in [s]."""
    return [
        time_
        for trip in trips
        for began, time_ in zip(trip["controller_began"], trip["controller"], strict=True)
        if any(begin <= began <= end for begin, end in windows)
    ]


def _number(path: Path) -> int:
    return int(path.read_text(encoding="utf-8"))
