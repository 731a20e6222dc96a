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

"""How long after its start a controller flies its first optimal plan, compiled or not.

Measured where a user waits: processes are started as a user starts them, once with an empty cache
and then again and again with what the first one has left there.
"""

from __future__ import annotations

import contextlib
import importlib.util
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from statistics import median
from typing import Any

import numpy as np

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.control.guidance import formulation_of
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.formulation.formulation import solver_at_once
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.study import Study

CONFIGURATIONS = ("paper", "small_uav")
PATIENCE = 120.0  # s for a flight to begin
FIRST_PLAN = "tracking: optimal plan"


def start_timing(repetitions: int) -> Study:
    """Times from the start of a process to its first optimal plan.

    Args:
        repetitions: Later starts, of which the median counts.

    Returns:
        Its content: ``start``, of each configuration in [s]: of the controller alone, and of a
        flight with three ROS 2 nodes (None without ROS), each first with an empty cache and then
        later, with the processor time that it would take on a core of its own; and of the
        compilation.
    """
    found = [_timed(config, repetitions) for config in CONFIGURATIONS]
    words = [line for each in found for line in in_words(each)]
    return Study("start", {"start": found}, words, "saved in {}")


def _timed(config: str, repetitions: int) -> dict[str, Any]:
    alone = [sys.executable, "-m", __name__, config]
    launcher = [sys.executable, "-m", "uav_tracking_mpc.cli.launch_tracking", "--config", config]
    compiler = [sys.executable, "-m", "uav_tracking_mpc", "compile", "--config", config]
    found: dict[str, Any] = {"config": config, "repetitions": repetitions}
    found |= _starts("controller_first", alone)
    with tempfile.TemporaryDirectory() as cache:
        begin = time.perf_counter()
        subprocess.run(compiler, env=_environment(cache), check=True, capture_output=True)
        found["compile_s"] = time.perf_counter() - begin
        found |= _starts("controller_later", alone, cache, repetitions)
        found |= {"flight_first_s": None, "flight_later_s": None}
        if importlib.util.find_spec("rclpy") is not None:
            found |= _starts("flight_first", launcher)
            found |= _starts("flight_later", launcher, cache, repetitions)
    return found


def _starts(name: str, command: Sequence[str], cache: str = "", count: int = 1) -> dict[str, float]:
    """Median of some starts, and the mean processor time of all children that ended, in [s].

    Without a cache it is one that is empty.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory() as empty:
        times = [_until_first_plan(command, cache or empty) for _ in range(count)]
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    return {f"{name}_s": median(times), f"{name}_cpu_s": used / count}


def in_words(found: dict[str, Any]) -> list[str]:
    """What was found of a configuration, for people."""
    lines = [f"{found['config']}: first optimal plan after the start of the process"]
    for key, words in (("controller", "controller alone"), ("flight", "flight, three ROS 2 nodes")):
        first, later = found[f"{key}_first_s"], found[f"{key}_later_s"]
        if first is not None:
            lines.append(f"  {words}: {first:.2f} s with an empty cache, {later:.2f} s later")
    return [
        *lines,
        "  processor time of the controller: {controller_first_cpu_s:.2f} s, "
        "{controller_later_cpu_s:.2f} s later".format_map(found),
        f"  compilation: {found['compile_s']:.1f} s",
    ]


def _environment(cache: str) -> dict[str, str]:
    kept = {name: value for name, value in os.environ.items() if name != "ROS_DOMAIN_ID"}
    return {**kept, "XDG_CACHE_HOME": cache}


def _until_first_plan(command: Sequence[str], cache: str) -> float:
    """Time in [s] until a process says that it flies an optimal plan; it is then ended."""
    begin = time.perf_counter()
    process = subprocess.Popen(
        command,
        env=_environment(cache),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
    )
    assert process.stdout is not None
    try:
        line = ""
        for line in process.stdout:
            if FIRST_PLAN in line:
                return time.perf_counter() - begin
        raise RuntimeError(f"{' '.join(command)} ended without a plan: {line.strip()}")
    finally:
        process.send_signal(signal.SIGTERM)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.communicate(timeout=PATIENCE)
        process.kill()


def fly_first_plan(config: str) -> None:
    """Start a controller as the node does, give it a state and a target, say what it flies.

    Args:
        config: Name of the configuration.
    """
    configuration = load_configuration(config)
    parameters = configuration.controller
    controller = Controller(parameters, formulation_of(parameters, solver_at_once(print)))
    x, y, z, heading, path_angle, airspeed = configuration.simulator.initial_state
    controller.see_target(0.0, [0.0, 0.0, 0.0])
    for step in range(100):
        stamp = step / parameters.control_rate
        east, north = airspeed * math.cos(heading), airspeed * math.sin(heading)
        position = np.array([x + east * stamp, y + north * stamp, z])
        velocity = np.array([east, north, 0.0])
        state = Measurement(stamp, position, velocity, heading, path_angle, airspeed=airspeed)
        command = controller.step(state, stamp)
        if command is not None and command.mode is FallbackMode.OPTIMAL:
            print(FIRST_PLAN, flush=True)
            return


if __name__ == "__main__":
    fly_first_plan(sys.argv[1])
