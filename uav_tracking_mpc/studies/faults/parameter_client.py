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

"""Client of the services that set the controller's parameters, from a process of its own."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import Parameter

from uav_tracking_mpc.parameters.specification import Specification, Value, specifications

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
        self._client = node.create_client(SetParameters, "nmpc_controller/set_parameters")
        self._whole = node.create_client(
            SetParametersAtomically, "nmpc_controller/set_parameters_atomically"
        )
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
        self._send(self._client, SetParameters.Request(parameters=_messages(values)), self._on_each)

    def put_back(self) -> None:
        """Ask for everything as it was configured, as a whole: a part of it may not be flyable."""
        self._put_back = time.monotonic()
        values = {**self.configured, "use_sim_time": True}
        request = SetParametersAtomically.Request(parameters=_messages(values))
        self._send(self._whole, request, self._on_whole)

    def _send(
        self, client: Client[Any, Any], request: Any, answered: Callable[[Any], None]
    ) -> None:
        if client.service_is_ready():
            self.asked += 1
            client.call_async(request).add_done_callback(answered)

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


def _messages(values: dict[str, Any]) -> list[ParameterMessage]:
    return [
        Parameter(name, value=list(value) if isinstance(value, tuple) else value).to_parameter_msg()
        for name, value in values.items()
    ]
