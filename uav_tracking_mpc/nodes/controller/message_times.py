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

"""When messages were measured, as the controller counts it: since the first stamp that was seen.

A stamp of zero is none. People publish points by hand without one, so a target's message without a
stamp counts as measured when it arrives. A driver that does not stamp the aircraft's state is
broken: how old the state is must be known.
"""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.messages.message_checks import MessageError
from uav_tracking_mpc.nodes.topics import Topic

BEGINNING = 1_000_000_000  # ns; before this zero is a time of a simulation that has just begun


class MessageTimes:
    """Times of messages in [s].

    Args:
        node: Whose clock says when a message arrives.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._origin: int | None = None
        self._told: set[str] = set()  # topics without stamps

    def now(self) -> float:
        """The node's clock; 0 before the first message."""
        return 0.0 if self._origin is None else (self._clock() - self._origin) * 1e-9

    def measured(self, topic: Topic, message: Any) -> float:
        """Time of a message that must have a stamp.

        Args:
            topic: From which it came.
            message: With a header.

        Raises:
            MessageError: It has none.
        """
        stamp = nanoseconds(message.header.stamp)
        if stamp == 0 and self._clock() >= BEGINNING:
            raise MessageError(
                f"{topic.name}: header.stamp is 0, must be when it was measured: is the driver "
                "right?"
            )
        return self._since_origin(stamp)

    def measured_or_now(self, topic: Topic, message: Any) -> float:
        """Time of a message; without a stamp that of its arrival, which is logged once.

        Args:
            topic: From which it came.
            message: With a header.
        """
        stamp = nanoseconds(message.header.stamp)
        if stamp == 0 and (now := self._clock()) >= BEGINNING:
            stamp = now
            if topic.name not in self._told:
                self._told.add(topic.name)
                self._node.get_logger().info(
                    f"{topic.name}: header.stamp is 0: such messages count as measured when they "
                    "arrive"
                )
        return self._since_origin(stamp)

    def _clock(self) -> int:
        return int(self._node.get_clock().now().nanoseconds)

    def _since_origin(self, stamp: int) -> float:
        if self._origin is None:
            self._origin = stamp
        return (stamp - self._origin) * 1e-9


DRAIN = 0.1  # s after a stop in which the queued messages arrive


class StallGuard:
    """Notices by the wall clock that the process was stopped or starved.

    Messages that came meanwhile are delivered one after the other, oldest first. In simulated time
    nothing in them tells their age, for time itself is a message.

    Args:
        limit: Time without a call of :meth:`alive` that counts as a stop, in [s]; longer than
            the period of whatever calls it regularly.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self._last: float | None = None
        self._until = -float("inf")

    def alive(self, now: float) -> bool:
        """Note that the process runs.

        Args:
            now: Time of the steady clock in [s].

        Returns:
            Whether a message that arrives now is new.
        """
        if self._last is not None and now - self._last > self._limit:
            self._until = now + DRAIN
        self._last = now
        return now >= self._until
