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

"""Publishers and subscriptions of the topics, with the quality of service that they are to have.

Each takes ``qos_overrides`` as ROS knows them: parameters such as
``qos_overrides./uav/odometry.subscription.reliability``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from uav_tracking_mpc.nodes.qos_overrides import PUBLISHER, SUBSCRIPTION, overriding_options
from uav_tracking_mpc.nodes.topics import Topic


def publish(
    node: Node,
    topic: Topic,
    qos: QoSProfile | None = None,
    event_callbacks: PublisherEventCallbacks | None = None,
) -> Publisher[Any]:
    """A publisher of a topic.

    Args:
        node: That publishes.
        topic: What is published.
        qos: Instead of the topic's own, where the node promises more.
        event_callbacks: As rclpy takes them.

    Raises:
        ParameterError: An override is not allowed.
    """
    return node.create_publisher(
        topic.type,
        topic.name,
        _copy(qos or topic.qos),
        event_callbacks=event_callbacks,
        qos_overriding_options=overriding_options(node, topic.name, PUBLISHER),
    )


def listen(
    node: Node,
    topic: Topic,
    callback: Callable[[Any], None],
    event_callbacks: SubscriptionEventCallbacks | None = None,
    raw: bool = False,
) -> Subscription[Any]:
    """A subscription of a topic.

    Args:
        node: That listens.
        topic: What is listened to.
        callback: Called with each message.
        event_callbacks: As rclpy takes them.
        raw: Whether it is called with the message as bytes.

    Raises:
        ParameterError: An override is not allowed.
    """
    return node.create_subscription(
        topic.type,
        topic.name,
        callback,
        _copy(topic.heard),
        event_callbacks=event_callbacks,
        qos_overriding_options=overriding_options(node, topic.name, SUBSCRIPTION),
        raw=raw,
    )


def _copy(qos: QoSProfile) -> QoSProfile:
    """A profile of its own: rclpy writes the overrides into the one that it is given."""
    return QoSProfile(**{name.lstrip("_"): getattr(qos, name) for name in qos.__slots__})
