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

"""Hearing a topic for the record, whatever its senders offer, without losing what is reliable.

A reliable subscription is not connected to a best-effort sender, and a best-effort one may lose
messages of a reliable sender. So the subscription is reliable until a best-effort sender shows up,
and best effort from then on, which connects with both.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.topics import Topic


class Overhearing:
    """A subscription that follows the senders.

    Args:
        node: That listens.
        topic: What is listened to.
        callback: Called with each message.
        depth: How many messages may wait.
        raw: Whether it is called with the message as bytes.
    """

    def __init__(
        self,
        node: Node,
        topic: Topic,
        callback: Callable[[Any], None],
        depth: int,
        raw: bool = False,
    ) -> None:
        self._node, self._topic, self._callback = node, topic, callback
        self._depth, self._raw = depth, raw
        self._change: Any = None  # timer of a change that is due
        self._subscription = self._listen(ReliabilityPolicy.RELIABLE)

    @property
    def senders(self) -> int:
        """How many are connected."""
        return int(self._subscription.get_publisher_count())

    def _listen(self, reliability: ReliabilityPolicy) -> Any:
        reliable = reliability is ReliabilityPolicy.RELIABLE
        # Where a topic keeps what was sent before anybody listened, that is heard, too.
        durability = self._topic.qos.durability
        return self._node.create_subscription(
            self._topic.type,
            self._topic.name,
            self._callback,
            QoSProfile(depth=self._depth, reliability=reliability, durability=durability),
            event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=self._on_incompatible if reliable else None
            ),
            raw=self._raw,
        )

    def _on_incompatible(self, event: object) -> None:
        # The subscription cannot be destroyed while its own event is handled.
        if self._change is None:
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self._change = self._node.create_timer(0.0, self._follow, clock=steady)

    def _follow(self) -> None:
        self._change.cancel()
        before = self._subscription
        self._subscription = self._listen(ReliabilityPolicy.BEST_EFFORT)
        self._node.destroy_subscription(before)
