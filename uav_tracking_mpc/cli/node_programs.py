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

"""The executables of the nodes: where ROS is missing, they say so like every command."""

from __future__ import annotations

import runpy
from collections.abc import Callable

from uav_tracking_mpc.cli.program import explained


def program(name: str) -> Callable[[], int]:
    """Entry point of an executable.

    Args:
        name: Of the node and of its module.

    Returns:
        Runs the node; it ends the process with its exit code.
    """

    def start() -> int:
        with explained(name) as ending:
            runpy.run_module(f"uav_tracking_mpc.nodes.{name}", run_name="__main__", alter_sys=True)
        return ending.code

    return start


uav_simulator = program("uav_simulator")
target_publisher = program("target_publisher")
nmpc_controller = program("nmpc_controller")
autopilot_link = program("autopilot_link")
monitor = program("monitor")
