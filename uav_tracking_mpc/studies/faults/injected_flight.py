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

"""The flight of real nodes that faults act on."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient

from uav_tracking_mpc.launch.supervisor import Supervisor
from uav_tracking_mpc.parameters.specification import Specification, Value, specifications
from uav_tracking_mpc.studies.faults.observer import Observer

ANSWER_LIMIT = 5.0  # s of wall time for the parameters to be put back


class ParameterClient:
    """Asks for parameters and puts them back.

    Args:
        node: Through which it asks.
        parameters: The dataclass whose fields are the controller's parameters, as configured.

    Attributes:
        known: Parameters of the controller.
        configured: Their values as configured, by name.
        asked: Requests sent.
        answered: Answers received.
        accepted: Parameters that were set.
    """

    def __init__(self, node: Node, parameters: Any) -> None:
        self._client = AsyncParameterClient(node, "nmpc_controller")
        self.known: list[Specification] = list(specifications(type(parameters)))
        self.configured: dict[str, Value] = {
            field.name: getattr(parameters, field.name) for field in dataclasses.fields(parameters)
        }
        self.asked = self.answered = self.accepted = 0
        self._put_back = 0.0

    def ask(self, values: dict[str, Any]) -> None:
        """Ask for values one by one, in one request; without a server nothing is asked.

        Args:
            values: By name, of any type.
        """
        self._send(self._client.set_parameters, values, self._on_each)

    def put_back(self) -> None:
        """Ask for everything as it was configured, as a whole: a part of it may not be flyable."""
        self._put_back = time.monotonic()
        values = {**self.configured, "use_sim_time": True}
        self._send(self._client.set_parameters_atomically, values, self._on_whole)

    def _send(
        self, request: Callable[..., Any], values: dict[str, Any], answered: Callable[[Any], None]
    ) -> None:
        if self._client.services_are_ready():
            self.asked += 1
            asked = {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}
            request([Parameter(name, value=value) for name, value in asked.items()], answered)

    def _on_each(self, future: Any) -> None:
        if (answer := future.result()) is not None:
            self.answered += 1
            self.accepted += sum(result.successful for result in answer.results)

    def _on_whole(self, future: Any) -> None:
        if (answer := future.result()) is not None:
            self.answered += 1
            self.accepted += len(self.configured) if answer.result.successful else 0

    @property
    def settled(self) -> bool:
        """Whether every request was answered, or too long ago.

        Answers come in order: with the last one nothing that was asked before is left.
        """
        waited = time.monotonic() - self._put_back
        return self.answered >= self.asked or waited > ANSWER_LIMIT


@dataclass(frozen=True)
class Flight:
    """What faults act on.

    Attributes:
        supervisor: Of the node processes.
        observer: Node that hears every message.
        order: Sends an order to the relay, as text.
        parameters: Client of the controller's parameters.
        speed: Simulated over wall time [-].
        reach: How far a target is teleported [m].
        now: Time by which faults begin and end [s].
    """

    supervisor: Supervisor
    observer: Observer
    order: Callable[[str], None]
    parameters: ParameterClient
    speed: float
    reach: float
    now: Callable[[], float] = time.monotonic
