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

"""The parameters of another node, read by its services without waiting for them."""

from __future__ import annotations

import time
from typing import Any, Generic, TypeVar

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

from uav_tracking_mpc.parameters.specification import ParameterError, from_mapping, specifications
from uav_tracking_mpc.parameters.specification import resolved as with_extensions

T = TypeVar("T")
PATIENCE = 5.0  # s for an answer, after which a node is asked again


class RemoteParameters(Generic[T]):
    """A node's parameters as a dataclass, as they were when it was asked last.

    Args:
        node: That asks.
        remote: Absolute name of the node that is asked.
        kind: The dataclass; parameters that it does not have are left out.

    Attributes:
        remote: Absolute name of the node that is asked.
        value: The parameters; None before they are known.
        trouble: Why its latest answer cannot be used, in words; empty if it can.
    """

    def __init__(self, node: Node, remote: str, kind: type[T]) -> None:
        self._node, self.remote, self._kind = node, remote, kind
        self.value: T | None = None
        self.trouble = ""
        self._stale, self._asked = True, -PATIENCE  # and when, steady [s]
        self._names: list[str] = []
        self._list = node.create_client(ListParameters, f"{remote}/list_parameters")
        self._get = node.create_client(GetParameters, f"{remote}/get_parameters")

    def follow(self) -> None:
        """Ask the node if it must be, and can be; called about once a second."""
        now = time.monotonic()
        if not self._stale or now - self._asked < PATIENCE:
            return
        if self._list.service_is_ready() and self._get.service_is_ready():
            self._asked = now
            future = self._list.call_async(ListParameters.Request())
            future.add_done_callback(self._on_names)

    def change(self) -> None:
        """Something has changed there: ask again."""
        self._stale, self._asked = True, -PATIENCE
        self.follow()

    def _on_names(self, future: Future[Any]) -> None:
        if (answer := _answer(future)) is None:
            return
        self._stale = False  # a change that comes from now on is asked for anew
        self._names = list(answer.result.names)
        request = GetParameters.Request(names=self._names)
        self._get.call_async(request).add_done_callback(self._on_values)

    def _on_values(self, future: Future[Any]) -> None:
        answer = _answer(future)
        if answer is None or len(answer.values) != len(self._names):
            self._stale = True  # a parameter came or went in between
            return
        said = map(parameter_value_to_python, answer.values)
        values = {
            name: value for name, value in zip(self._names, said, strict=True) if value is not None
        }
        try:
            kind = with_extensions(self._kind, values)
            known = {specification.name for specification in specifications(kind)}
            told = {name: value for name, value in values.items() if name in known}
            self.value, self.trouble = from_mapping(kind, told), ""
        except (ParameterError, ImportError) as error:
            self.trouble = f"parameters of {self.remote}: {error}"
            self._node.get_logger().warning(self.trouble)


def _answer(future: Future[Any]) -> Any:
    """What was answered; None where nothing was, as when the node ended meanwhile."""
    return None if future.cancelled() or future.exception() else future.result()
