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

"""What rclpy keeps to itself and nodes need all the same: the one place that reaches into it.

It was written against rclpy of Jazzy; another version may name these things otherwise.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock

NAMELESS = "_NODE_NAME_UNKNOWN_"  # a node that was discovered a moment ago


def parameter_overrides(node: Node) -> dict[str, Any]:
    """Parameters that a node was given at its start, by name, whether it knows them or not.

    Args:
        node: That was given them.
    """
    overrides: dict[str, Any] = getattr(node, "_parameter_overrides", {})
    return {name: parameter.value for name, parameter in overrides.items()}


def declared_parameters(node: Node) -> list[str]:
    """Names of all parameters of a node, in order.

    Args:
        node: That declared them.
    """
    return sorted(node._parameters)


def wrap_transitions(node: LifecycleNode, wrap: Callable[[Callable[..., Any]], Any]) -> None:
    """Put a function around the service that asks a managed node for a transition.

    Args:
        node: Managed.
        wrap: From the service's callback to the one that is called instead.
    """
    service = node._service_change_state
    service.callback = wrap(service.callback)


def refuse_negative_time(node: Node) -> None:
    """Leave out simulated time below 0, with a warning: rclpy raises, which would end the process.

    Args:
        node: That may follow simulated time.
    """
    subscription = node._time_source._clock_sub
    if subscription is None:
        return
    follow = subscription.callback

    def checked(message: Clock) -> None:
        if message.clock.sec >= 0:
            follow(message)
            return
        words = f"/clock: the time is {message.clock.sec} s, must be at least 0: it is left out"
        node.get_logger().warning(words, once=True)

    subscription.callback = checked


class NumberedSubscription:
    """The sequence numbers of a topic's messages: executors call nobody with them.

    Where a security policy forbids to listen, there are none.

    Args:
        node: That listens.
        kind: Type of the messages.
        name: Of the topic.
        qos: That is asked for.
    """

    def __init__(self, node: Node, kind: type, name: str, qos: QoSProfile) -> None:
        self._type, self._subscription = kind, None
        with suppress(rclpy_implementation.RCLError), node.handle:
            self._subscription = rclpy_implementation.Subscription(
                node.handle, kind, name, qos.get_c_qos_profile()
            )

    def numbers(self) -> Iterator[int | None]:
        """Those of the messages since the last call; None where there are none to be had."""
        if self._subscription is None:
            yield None
            return
        with self._subscription:
            while (taken := self._subscription.take_message(self._type, True)) is not None:
                yield taken[1]["publication_sequence_number"]

    def close(self) -> None:
        """Listen no longer."""
        if self._subscription is not None:
            self._subscription.destroy_when_not_in_use()
