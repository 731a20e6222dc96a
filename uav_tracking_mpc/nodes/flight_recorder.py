"""Node ``flight_recorder``: every topic of a flight into a bag, and what a progress line shows."""

from __future__ import annotations

import functools
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    position_from_point,
)
from uav_tracking_mpc.nodes.flight_bag import FlightBag
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    ODOMETRY,
    TARGET,
    TRACKING,
    Topic,
)

QUEUE = QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)


@dataclass(frozen=True)
class Progress:
    """Where a flight stands.

    Attributes:
        time: Since the first command in [s], None before it.
        range: Distance to the target in [m].
        altitude: Height above the target in [m].
        speed: Through the air, over ground where that is not known, in [m/s].
        solve_time: Of the last solve in [s].
    """

    time: float | None = None
    range: float = float("nan")
    altitude: float = float("nan")
    speed: float = float("nan")
    solve_time: float = float("nan")


class FlightRecorder(Node):
    """Hears everything and, given a bag, writes it down without decoding it.

    Args:
        bag: Where to write; None only listens.
        options: As those of rclpy's Node.
    """

    def __init__(self, bag: FlightBag | None = None, **options: Any) -> None:
        super().__init__("flight_recorder", **options)
        self._bag = bag
        self._latest: dict[str, bytes] = {}
        self._start: int | None = None
        # The simulator's time may wait for this node: it listens to the state, and so releases
        # the simulator, only when it hears everything else.
        others = [(topic, self._listen(topic)) for topic in ALL if topic is not ODOMETRY]
        self._needed = [subscription for topic, subscription in others if not topic.optional]
        self._waiting = self.create_timer(
            0.05, self._release, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _listen(self, topic: Topic) -> Subscription:
        callback = functools.partial(self._on_message, topic)
        return self.create_subscription(topic.type, topic.name, callback, QUEUE, raw=True)

    def _release(self) -> None:
        if all(subscription.get_publisher_count() for subscription in self._needed):
            self._waiting.cancel()
            self._listen(ODOMETRY)

    def _on_message(self, topic: Topic, data: bytes) -> None:
        now = time.time_ns()
        self._latest[topic.name] = data
        if topic is COMMAND and self._start is None:
            self._start = nanoseconds(deserialize_message(data, topic.type).header.stamp)
        if self._bag is not None:
            self._bag.write(topic, now, data)

    def progress(self) -> Progress:
        """Where the flight stands by the latest messages."""
        odometry, target = self._message(ODOMETRY), self._message(TARGET)
        air = self._message(AIR_VELOCITY)
        if odometry is None or target is None:
            return Progress()
        try:
            motion, position = measurement_from_odometry(odometry), position_from_point(target)
            velocity = motion.ground_velocity if air is None else air_velocity_from_twist(air)
        except MessageError:
            return Progress()
        solve_time = self._message(TRACKING["solve_time"])
        stamp = nanoseconds(odometry.header.stamp)
        return Progress(
            time=None if self._start is None else (stamp - self._start) * 1e-9,
            range=float(np.linalg.norm(motion.position - position)),
            altitude=float(motion.position[2] - position[2]),
            speed=math.hypot(*velocity),
            solve_time=float("nan") if solve_time is None else solve_time.data,
        )

    def _message(self, topic: Topic) -> Any:
        data = self._latest.get(topic.name)
        return None if data is None else deserialize_message(data, topic.type)
