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

"""Node ``fault_relay``: stands in every topic's way and injects the stream faults it is told to."""

from __future__ import annotations

import functools
import heapq
import itertools
import json
import random
import sys
import time
from typing import Any, cast

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from uav_tracking_mpc.autopilot.deliveries import struck
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import Topic
from uav_tracking_mpc.studies.faults.schedule import variants
from uav_tracking_mpc.studies.faults.stream_fault import ORDERS, STREAMS, StreamFault, raw

TICK = 0.005  # s of wall time


class FaultRelay(Node):
    """Forwards every message as it is, serialized, unless a fault strikes it.

    Args:
        options: As of rclpy's Node.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("fault_relay", **options)
        self._under_way: list[tuple[float, StreamFault]] = []  # its end, a steady time in s
        self._late: list[tuple[float, int, str, bytes]] = []  # due, order, topic, message
        self._order = itertools.count()
        self._speed = 1.0  # simulated over wall time
        self._outputs = {
            topic.name: self.create_publisher(topic.type, topic.name, topic.qos)
            for topic in STREAMS
        }
        for topic in STREAMS:
            callback = functools.partial(self._on_message, topic)
            FollowingSubscription(self, raw(topic), callback, ORDERS.quality.depth, raw=True)
        self.create_subscription(ORDERS.type, ORDERS.name, self._on_order, ORDERS.qos)
        self.create_timer(TICK, self._send_late, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_order(self, message: Any) -> None:
        order = json.loads(message.data)
        fault = cast(StreamFault, variants(order["reference"])[order["fault"]])
        fault.prepare(random.Random(order["seed"]), order["reach"])
        self._under_way.append((time.monotonic() + order["seconds"], fault))
        self._speed = order["speed"]

    def _on_message(self, topic: Topic, data: bytes) -> None:
        now = time.monotonic()
        self._under_way = [running for running in self._under_way if running[0] > now]
        rules = [fault for _, fault in self._under_way if topic in fault.streams]
        for delay, message in struck(rules, topic, data, now):
            if delay <= 0.0:
                self._outputs[topic.name].publish(message)
            else:
                due = now + delay / self._speed
                heapq.heappush(self._late, (due, next(self._order), topic.name, message))

    def _send_late(self) -> None:
        now = time.monotonic()
        while self._late and self._late[0][0] <= now:
            _, _, topic, message = heapq.heappop(self._late)
            self._outputs[topic].publish(message)


if __name__ == "__main__":
    sys.exit(run("fault_relay", FaultRelay))
