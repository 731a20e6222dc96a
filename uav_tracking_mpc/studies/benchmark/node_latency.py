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

"""How long three real nodes take from a state to its command, beside an echo of the messages."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console

from uav_tracking_mpc.launch.supervisor import supervised
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.studies.benchmark.timed_nodes import (
    controller_of,
    processor_time,
    start_timed_nodes,
    summary,
    wait,
)


def node_latency(
    configuration: Configuration, duration: float, progress: Callable[[str], None]
) -> dict[str, Any]:
    """Fly in wall time and measure.

    Args:
        configuration: What is flown, at its rates.
        duration: In [s], after a warm-up.
        progress: Told what goes on.

    Returns:
        ``state_to_command_us`` and ``echo_us`` {median, p99, max, count}: from before a state is
        published in the simulator's process to the arrival of its command there; ``ratio`` of
        their medians; ``controller_cpu_share`` of a core, the echo's answers included; the
        configuration's name, and the rates in [Hz].

    Raises:
        LaunchError: A node died, or nothing flew.
    """
    with tempfile.TemporaryDirectory() as folder, supervised(Console(stderr=True)) as supervisor:
        progress("nodes: warm-up")
        (result,) = start_timed_nodes(supervisor, Path(folder), configuration)
        controller = supervisor.processes[controller_of("")].identity
        begin, used = time.monotonic(), processor_time(controller)
        progress(f"nodes: {duration:g} s of flight")
        wait(supervisor, duration)
        share = (processor_time(controller) - used) / (time.monotonic() - begin)
        supervisor.end()
        times = json.loads(result.read_text(encoding="utf-8"))
    controller_times, echo_times = (summary(times[name]) for name in ("controller", "echo"))
    return {
        "config": configuration.name,
        "state_rate_hz": configuration.simulator.state_rate,
        "control_rate_hz": configuration.controller.control_rate,
        "state_to_command_us": controller_times,
        "echo_us": echo_times,
        "ratio": controller_times["median"] / echo_times["median"],
        "controller_cpu_share": share,
    }


def in_words(results: dict[str, Any]) -> list[str]:
    """Lines of text.

    Args:
        results: Of :func:`node_latency`.
    """
    lines = [
        f"{results['config']}, three nodes, {results['control_rate_hz']:g} commands a second, "
        "published state to received command:"
    ]
    for name, key in (("controller", "state_to_command_us"), ("echo", "echo_us")):
        row = results[key]
        lines.append(
            f"  {name:10s} median {row['median']:6.0f} us   p99 {row['p99']:6.0f} us   "
            f"max {row['max']:6.0f} us   of {row['count']}"
        )
    lines.append(
        f"  ratio {results['ratio']:.2f}; the controller's process takes "
        f"{100.0 * results['controller_cpu_share']:.0f} % of a core"
    )
    return lines
