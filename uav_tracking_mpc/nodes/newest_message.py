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

"""The newest message of a topic: kept as it came, read when it is looked at.

Who only looks must not slow down who flies: the subscription is best effort, which connects with
every sender and asks none of them to send anything again. A message costs little before it is
looked at, however many come.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Generic, TypeVar

from rclpy.node import Node

from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.nodes.topics import SENSED, Topic

T = TypeVar("T")


class NewestMessage(Generic[T]):
    """What came last on a topic.

    Looked at by one thread, which need not be the one that spins the node.

    Args:
        node: That listens.
        topic: What is listened to.
        read: From the serialized message to what it says.

    Attributes:
        trouble: Why the newest message cannot be used, in words; empty if it can.
    """

    def __init__(self, node: Node, topic: Topic, read: Callable[[bytes], T]) -> None:
        self._read = read
        self._heard: tuple[bytes, float] | None = None  # and when it came, steady [s]
        self._looked_at: bytes | None = None
        self._value: T | None = None
        self.trouble = ""
        node.create_subscription(topic.type, topic.name, self._on_message, SENSED, raw=True)

    def _on_message(self, data: bytes) -> None:
        self._heard = data, time.monotonic()

    @property
    def arrival(self) -> float:
        """When it came, steady, in [s]; minus infinity before the first."""
        return -math.inf if self._heard is None else self._heard[1]

    @property
    def value(self) -> T | None:
        """What it says; None before the first, and where it cannot be used."""
        heard = self._heard
        if heard is not None and heard[0] is not self._looked_at:
            self._looked_at, self.trouble, self._value = heard[0], "", None
            try:
                self._value = self._read(heard[0])
            except MeasurementError as error:
                self.trouble = str(error)
        return self._value
