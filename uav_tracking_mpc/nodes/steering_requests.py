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

"""Requests to the nodes of one aircraft from another node: parameters, services, the target's goal.

The node that asks is spun in another thread than the one that asks.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters, ListParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.qos import qos_profile_parameter_events
from rclpy.serialization import deserialize_message
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.nodes.conversions import set_vector
from uav_tracking_mpc.nodes.newest_message import NewestMessage
from uav_tracking_mpc.nodes.topics import TARGET_GOAL, TARGET_TRUTH

EVENTS = "/parameter_events"
LIMIT = 5.0  # s of wall time for an answer
PARAMETER_SERVICES = {
    "list_parameters": ListParameters,
    "get_parameters": GetParameters,
    "set_parameters_atomically": SetParametersAtomically,
}


def asking_node(context: Context) -> Node:
    """A node for requests alone.

    Args:
        context: Of rclpy, in the domain that is asked.
    """
    return Node("uav_tracking", context=context, start_parameter_services=False)


class NoAnswerError(RuntimeError):
    """A node is not there, or did not answer in time; the message names it."""


class SteeringRequests:
    """What can be asked of the nodes of an aircraft. Every request waits for its answer.

    Args:
        node: That asks, in an executor that is spun in a thread of its own.
        namespace: Of the aircraft, with or without slashes at its ends; empty for none.
        owners: Nodes whose parameters are asked for.
        switches: Services of type SetBool, each as ``node/service``.
        triggers: Services of type Trigger, each as ``node/service``.
    """

    def __init__(
        self,
        node: Node,
        namespace: str,
        owners: Sequence[str],
        switches: Sequence[str],
        triggers: Sequence[str],
    ) -> None:
        self._namespace = namespace.strip("/")
        kinds = {f"{o}/{name}": kind for o in owners for name, kind in PARAMETER_SERVICES.items()}
        kinds |= dict.fromkeys(switches, SetBool) | dict.fromkeys(triggers, Trigger)
        self._clients: dict[str, Client] = {
            service: node.create_client(kind, self._absolute(service))
            for service, kind in kinds.items()
        }
        # A node that flies is asked for its parameters once, and again when it says that they have
        # changed: to answer takes it time.
        self._owners = {self._absolute(owner): owner for owner in owners}
        self._known: dict[str, dict[str, Any]] = {}
        self._changes: Counter[str] = Counter()
        node.create_subscription(
            ParameterEvent, EVENTS, self._on_event, qos_profile_parameter_events
        )
        self._goals = node.create_publisher(
            TARGET_GOAL.type, self._absolute(TARGET_GOAL.name), TARGET_GOAL.qos
        )
        self._truth = NewestMessage(
            node,
            replace(TARGET_TRUTH, name=self._absolute(TARGET_TRUTH.name)),
            lambda data: deserialize_message(data, TARGET_TRUTH.type),
        )

    def _absolute(self, name: str) -> str:
        return "/" + "/".join(filter(None, (self._namespace, name)))

    def _on_event(self, event: ParameterEvent) -> None:
        if (owner := self._owners.get(event.node)) is not None:
            self._changes[owner] += 1
            self._known.pop(owner, None)

    def offered(self, service: str) -> bool:
        """Whether somebody offers a service now; one that was killed counts for some seconds.

        Args:
            service: As ``node/service``.
        """
        return bool(self._clients[service].service_is_ready())

    def _ask(self, service: str, **request: Any) -> Any:
        client, owner = self._clients[service], service.partition("/")[0]
        if not self.offered(service):
            raise NoAnswerError(f"{owner} is not there")
        answer = client.call(client.srv_type.Request(**request), timeout_sec=LIMIT)
        if answer is None:
            raise NoAnswerError(f"{owner} did not answer within {LIMIT:g} s")
        return answer

    def parameters(self, owner: str) -> dict[str, Any]:
        """Values of a node's parameters by name.

        Args:
            owner: The node.

        Raises:
            NoAnswerError: It did not answer.
        """
        known, changes = self._known.get(owner), self._changes[owner]
        if known is not None and self.offered(f"{owner}/get_parameters"):
            return dict(known)
        names = self._ask(f"{owner}/list_parameters").result.names
        values = self._ask(f"{owner}/get_parameters", names=names).values
        said = {
            name: parameter_value_to_python(value)
            for name, value in zip(names, values, strict=False)  # none where one has gone meanwhile
        }
        if changes == self._changes[owner]:
            self._known[owner] = said
        return dict(said)

    def change(self, owner: str, values: Mapping[str, Any]) -> str:
        """Set parameters of a node as a whole, or not at all.

        Args:
            owner: The node.
            values: By name.

        Returns:
            Why they were refused, in the node's own words; empty where they were set.

        Raises:
            NoAnswerError: It did not answer.
        """
        wanted = [
            Parameter(name, value=_ros_value(value)).to_parameter_msg()
            for name, value in values.items()
        ]
        result = self._ask(f"{owner}/set_parameters_atomically", parameters=wanted).result
        self._changes[owner] += 1  # what it says of itself may come later than its answer
        self._known.pop(owner, None)
        return "" if result.successful else result.reason or f"{owner} refused without a reason"

    def call(self, service: str, **request: Any) -> str:
        """Call a service of type SetBool or Trigger.

        Args:
            service: As ``node/service``.
            request: ``data`` of a SetBool.

        Returns:
            Why it was refused, in the node's own words; empty where it was done.

        Raises:
            NoAnswerError: It did not answer.
        """
        answer = self._ask(service, **request)
        return "" if answer.success else answer.message or f"{service} refused without a reason"

    def send_goal(self, east: float, north: float) -> tuple[float, float, float] | None:
        """Publish where the target is to go, at the height that it has.

        Args:
            east: In ``map`` in [m].
            north: In ``map`` in [m].

        Returns:
            The goal in ``map`` in [m]; None where nobody says how high the target is.
        """
        if (truth := self._truth.value) is None:
            return None
        goal = (float(east), float(north), float(truth.pose.pose.position.z))
        message = TARGET_GOAL.type()
        message.header.frame_id = truth.header.frame_id
        set_vector(message.point, np.array(goal))
        self._goals.publish(message)
        return goal


def _ros_value(value: Any) -> Any:
    """As ROS takes it: a list of numbers holds floats alone."""
    if isinstance(value, (tuple, list, np.ndarray)):
        return [float(number) for number in value]
    return value.item() if isinstance(value, np.generic) else value
