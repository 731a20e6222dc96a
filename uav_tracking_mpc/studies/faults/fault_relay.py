"""Node ``fault_relay``: stands in every topic's way and does to the messages what it is told."""

from __future__ import annotations

import functools
import heapq
import json
import sys
import time
from dataclasses import replace
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import String

from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    CLOCK,
    COMMAND,
    ODOMETRY,
    TARGET,
    Topic,
)
from uav_tracking_mpc.studies.faults.message_faults import MessageFault

QUEUE = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
ORDERS = Topic(
    "torture/fault", String, QUEUE, "campaign", "A fault as JSON: kind, seed, seconds, speed, reach"
)
RELAYED = (ODOMETRY, AIR_VELOCITY, TARGET, COMMAND, CLOCK)
TICK = 0.005  # s of wall time


def raw(topic: Topic) -> Topic:
    """The topic before the relay: what its sender truly sent."""
    return replace(topic, name=f"/raw{topic.name}" if topic is CLOCK else f"raw/{topic.name}")


class FaultRelay(Node):
    """Forwards every message as it is, serialized, unless a fault strikes it."""

    def __init__(self, **options: Any) -> None:
        super().__init__("fault_relay", **options)
        self._types = {topic.name: topic.type for topic in RELAYED}
        self._faults: list[tuple[float, float, MessageFault]] = []  # end, speed, fault
        self._late: list[tuple[float, int, str, bytes]] = []  # due, order, topic, message
        self._order = 0
        self._outputs = {
            topic.name: self.create_publisher(topic.type, topic.name, topic.qos)
            for topic in RELAYED
        }
        for topic in RELAYED:
            callback = functools.partial(self._on_message, topic.name)
            self.create_subscription(topic.type, raw(topic).name, callback, QUEUE, raw=True)
        self.create_subscription(ORDERS.type, ORDERS.name, self._on_order, ORDERS.qos)
        self.create_timer(TICK, self._send_late, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def _on_order(self, message: Any) -> None:
        order = json.loads(message.data)
        fault = MessageFault(
            order["kind"],
            order["seed"],
            order["reach"],
            lambda topic, data: deserialize_message(data, self._types[topic]),
            serialize_message,
        )
        self._faults.append((time.monotonic() + order["seconds"], order["speed"], fault))

    def _on_message(self, topic: str, data: bytes) -> None:
        now = time.monotonic()
        deliveries = [(0.0, data)]
        if self._faults:
            self._faults = [fault for fault in self._faults if fault[0] > now]
            for _, speed, fault in self._faults:
                deliveries = [
                    (delay + more / speed, struck)
                    for delay, whole in deliveries
                    for more, struck in fault.deliver(topic, whole)
                ]
        for delay, message in deliveries:
            if delay <= 0.0:
                self._outputs[topic].publish(message)
            else:
                self._order += 1
                heapq.heappush(self._late, (now + delay, self._order, topic, message))

    def _send_late(self) -> None:
        now = time.monotonic()
        while self._late and self._late[0][0] <= now:
            _, _, topic, message = heapq.heappop(self._late)
            self._outputs[topic].publish(message)


def main() -> int:
    """Entry point of the process."""
    return run("fault_relay", FaultRelay)


if __name__ == "__main__":
    sys.exit(main())
