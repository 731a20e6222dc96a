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

"""Parameters ``qos_overrides.TOPIC.publisher|subscription.POLICY``: checked, and none in vain.

rclpy ends in a traceback on a value that it does not know, and ignores an override that no endpoint
of the node takes.
"""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rclpy.qos import HistoryPolicy, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions

from uav_tracking_mpc.parameters.specification import ParameterError

PREFIX = "qos_overrides."
PUBLISHER, SUBSCRIPTION = "publisher", "subscription"
POLICIES = {"history": HistoryPolicy, "reliability": ReliabilityPolicy}  # and depth
DEPTH_MAX = 10_000  # messages


def overriding_options(node: Node, topic: str, kind: str) -> QoSOverridingOptions:
    """What rclpy takes, once the overrides of an endpoint have been checked.

    Args:
        node: Whose endpoint it is.
        topic: Name of the topic as the node knows it.
        kind: PUBLISHER or SUBSCRIPTION.

    Raises:
        ParameterError: An override is not allowed.
    """
    overrides = _overrides(node)
    begin = f"{PREFIX}{node.resolve_topic_name(topic)}.{kind}."
    for policy, values in POLICIES.items():
        name = f"{begin}{policy}"
        allowed = [each.name.lower() for each in values if each.name != "UNKNOWN"]
        if name in overrides and str(overrides[name]).lower() not in allowed:
            raise _error(name, overrides[name], f"one of {', '.join(allowed)}")
    name = f"{begin}depth"
    depth = overrides.get(name, 1)
    if isinstance(depth, bool) or not (isinstance(depth, int) and 1 <= depth <= DEPTH_MAX):
        raise _error(name, depth, f"an integer from 1 to {DEPTH_MAX}")
    return QoSOverridingOptions.with_default_policies()


def warn_of_vain_overrides(node: Node) -> None:
    """Warn of overrides that no endpoint of a node has taken.

    Args:
        node: With all its publishers and subscriptions.
    """
    for name in _overrides(node):
        if name.startswith(PREFIX) and not node.has_parameter(name):
            known = sorted(each for each in node._parameters if each.startswith(PREFIX))
            node.get_logger().warning(
                f"parameter '{name}' is unknown and has no effect; known are: {', '.join(known)}"
            )


def _overrides(node: Node) -> dict[str, Any]:
    found: dict[str, Any] = getattr(node, "_parameter_overrides", {})
    return {name: parameter.value for name, parameter in found.items()}


def _error(name: str, value: Any, allowed: str) -> ParameterError:
    return ParameterError(f"parameter '{name}' is {value!r}, must be {allowed}")
