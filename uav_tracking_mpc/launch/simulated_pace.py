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

"""How fast simulated time runs: no faster than real time while the solver is being compiled.

The solver that stands in meanwhile takes tens of milliseconds for a plan, which is enough in real
time and not at ten times that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rich.console import Console

from uav_tracking_mpc.control.compiled_flight import compiled_into
from uav_tracking_mpc.mpc import machine_code
from uav_tracking_mpc.settings.configuration import Configuration

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.task import Future

SIMULATOR = "uav_simulator"
REAL_TIME = 1.0


class SimulatedPace:
    """Speed of a simulated flight.

    Args:
        configuration: What is flown; its mission says how fast.
        node: With which the simulator is told.
        console: Where it is said that the simulator refused.

    Attributes:
        speed: Simulated over wall time at the start [-].
    """

    def __init__(self, configuration: Configuration, node: Node, console: Console) -> None:
        self._wanted = configuration.mission.speed
        self._console = console
        self._folder = compiled_into(configuration.controller)
        waits = self._folder is not None and not machine_code.finished(self._folder)
        self._done = not waits or self._wanted <= REAL_TIME
        self.speed = self._wanted if self._done else REAL_TIME
        self._client = node.create_client(SetParameters, f"{SIMULATOR}/set_parameters")

    def follow(self) -> None:
        """Ask for the wanted speed once the solver is compiled; returns at once."""
        if self._done or self._folder is None or not machine_code.finished(self._folder):
            return
        if not self._client.service_is_ready():
            return
        self._done = True
        value = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=self._wanted)
        request = SetParameters.Request(parameters=[Parameter(name="speed", value=value)])
        self._client.call_async(request).add_done_callback(self._answered)

    def _answered(self, answer: Future) -> None:
        response = answer.result()
        result = None if response is None else response.results[0]
        if result is not None and not result.successful:
            words = f"simulated time goes on at {self.speed:g} times real time: {result.reason}"
            self._console.print(words, markup=False, highlight=False, soft_wrap=True)
