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

"""The timed nodes of one or several aircraft, and what is read of their processes."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from uav_tracking_mpc.control.compiled_flight import compile_flight
from uav_tracking_mpc.launch.supervisor import LaunchError, Supervisor
from uav_tracking_mpc.settings.configuration import Configuration

ROOM = "uav_tracking_mpc.studies.benchmark"
START_LIMIT = 180.0  # s until the warm-up is flown, with the solver's compilation
LOOK_PERIOD = 0.2  # s


def start_timed_nodes(
    supervisor: Supervisor,
    folder: Path,
    configuration: Configuration,
    namespaces: Sequence[str] = ("",),
) -> list[Path]:
    """Start the nodes and wait until each aircraft has flown its warm-up.

    Args:
        supervisor: Starts them.
        folder: For their parameters and results.
        configuration: What each aircraft flies.
        namespaces: Of the aircraft; empty for none.

    Returns:
        The file of each aircraft into which its simulator writes the times when it ends.

    Raises:
        LaunchError: A node died, or nothing flew.
    """
    compile_flight(configuration.controller)  # what is measured is not another solver
    parameters = folder / "flight.yaml"
    parameters.write_text(configuration.yaml(), encoding="utf-8")
    results = [folder / f"round_trips{space}.json" for space in namespaces]
    for space, result in zip(namespaces, results, strict=True):
        told = ["--ros-args", "--params-file", str(parameters), "--log-level", "WARN"]
        if space:
            told += ["-r", f"__ns:=/{space}"]
        supervisor.start(controller_of(space), f"{ROOM}.timed_controller", told)
        target = f"{space} target_publisher".strip()
        supervisor.start(target, "uav_tracking_mpc.nodes.target_publisher", told)
        for assignment in (f"round_trips:={result}", "start_on_command:=true"):
            told = [*told, "-p", assignment]
        supervisor.start(f"{space} uav_simulator".strip(), f"{ROOM}.timed_simulator", told)
    wait(supervisor, START_LIMIT, lambda: all(result.exists() for result in results))
    if not all(result.exists() for result in results):
        raise LaunchError(f"the nodes have not flown within {START_LIMIT:g} s")
    return results


def controller_of(namespace: str) -> str:
    """Name of a controller's process.

    Args:
        namespace: Of the aircraft; empty for none.
    """
    return f"{namespace} nmpc_controller".strip()


def wait(supervisor: Supervisor, limit: float, done: Callable[[], bool] = lambda: False) -> None:
    """Wait until something is done, watching the processes.

    Args:
        supervisor: Of the processes.
        limit: Longest time in [s].
        done: Whether it is.

    Raises:
        LaunchError: A process has ended.
    """
    end = time.monotonic() + limit
    while time.monotonic() < end and not done():
        supervisor.check()
        time.sleep(min(LOOK_PERIOD, max(end - time.monotonic(), 0.0)))


def processor_time(process: int) -> float:
    """What a process has used so far in [s].

    Args:
        process: Its id.
    """
    fields = Path(f"/proc/{process}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    user, system = int(fields[11]), int(fields[12])
    return (user + system) / os.sysconf("SC_CLK_TCK")


def resident_memory(process: int) -> float:
    """What a process holds in memory in [MB].

    Args:
        process: Its id.
    """
    lines = Path(f"/proc/{process}/status").read_text(encoding="utf-8").splitlines()
    (held,) = (line.split()[1] for line in lines if line.startswith("VmRSS:"))
    return int(held) / 1024.0


def summary(times: Sequence[float]) -> dict[str, float]:
    """Median, p99, max in [us] and count.

    Args:
        times: In [s].

    Raises:
        LaunchError: There are none.
    """
    if not len(times):
        raise LaunchError("no state was answered")
    micros = 1e6 * np.array(times)
    return {
        "median": float(np.median(micros)),
        "p99": float(np.percentile(micros, 99.0)),
        "max": float(micros.max()),
        "count": len(times),
    }
