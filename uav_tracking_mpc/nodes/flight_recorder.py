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

"""Node ``flight_recorder``: every topic of a flight into a bag, and what a progress line shows."""

from __future__ import annotations

import functools
import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from uav_tracking_mpc.nodes.bag.flight_bag import FlightBag
from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    position_from_point,
)
from uav_tracking_mpc.nodes.messages.message_checks import ANY_FRAMES, MessageError
from uav_tracking_mpc.nodes.messages.target_messages import target_from_odometry
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    ENGAGED,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
    Topic,
)

QUEUE = 100  # messages of a topic; as many as come while a chunk of the bag is compressed


@dataclass(frozen=True)
class Progress:
    """Where a flight stands.

    Attributes:
        time: Since the first command, or since the autopilot was engaged, in [s]; None before it.
        engaged: Whether a real autopilot flies the commands; None where none says so.
        range: Distance to the target in [m].
        altitude: Height above the target in [m].
        speed: Through the air, over ground where that is not known, in [m/s].
        solve_time: Of the last solve in [s].
    """

    time: float | None = None
    engaged: bool | None = None
    range: float = float("nan")
    altitude: float = float("nan")
    speed: float = float("nan")
    solve_time: float = float("nan")


class FlightRecorder(Node):
    """Hears everything and, given a bag, writes it down without decoding it.

    Args:
        bag: Where to write; None only listens.
        link: Whether a real autopilot flies: time is then the wall's, and counts from when it is
            engaged.
        options: As those of rclpy's Node.
    """

    def __init__(self, bag: FlightBag | None = None, link: bool = False, **options: Any) -> None:
        super().__init__("flight_recorder", **options)
        self._bag, self._link = bag, link
        self._latest: dict[str, bytes] = {}
        self._start: int | None = None
        # The simulator's time may wait for this node: it listens to the state, and so releases
        # the simulator, only when it hears everything else.
        others = [(topic, self._listen(topic)) for topic in ALL if topic is not ODOMETRY]
        self._needed = [overhearing for topic, overhearing in others if not topic.optional]
        self._waiting = self.create_timer(
            0.05, self._release, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _listen(self, topic: Topic) -> FollowingSubscription:
        callback = functools.partial(self._on_message, topic)
        return FollowingSubscription(self, topic, callback, QUEUE, raw=True)

    def _release(self) -> None:
        if self._link or all(each.senders for each in self._needed):
            self._waiting.cancel()
            self._listen(ODOMETRY)

    def _on_message(self, topic: Topic, data: bytes) -> None:
        now = time.time_ns()
        self._latest[topic.name] = data
        if self._start is None and topic is (ENGAGED if self._link else COMMAND):
            self._begin(deserialize_message(data, topic.type), now)
        if self._bag is not None:
            self._bag.write(topic, now, data)

    def _begin(self, message: Any, now: int) -> None:
        """Count the time from this message on, if it is the one that begins the flight."""
        if not self._link:
            self._start = nanoseconds(message.header.stamp)
        elif message.data:
            self._start = now

    def _target(self) -> NDArray[np.float64]:
        """Where the target was measured last, shape (3,), in [m]; nan if it never was."""
        if (point := self._message(TARGET)) is not None:
            return position_from_point(point, ANY_FRAMES)
        track = self._message(TARGET_ODOMETRY)
        return (
            np.full(3, np.nan)
            if track is None
            else target_from_odometry(track, ANY_FRAMES).position
        )

    def progress(self) -> Progress:
        """Where the flight stands by the latest messages."""
        odometry, air = self._message(ODOMETRY), self._message(AIR_VELOCITY)
        engaged = self._message(ENGAGED)
        if odometry is None:
            return Progress()
        try:
            motion, position = (
                measurement_from_odometry(odometry, frames=ANY_FRAMES),
                self._target(),
            )
            velocity = (
                motion.ground_velocity if air is None else air_velocity_from_twist(air, ANY_FRAMES)
            )
        except MessageError:
            return Progress()
        solve_time = self._message(TRACKING["solve_time"])
        stamp = nanoseconds(odometry.header.stamp)
        return Progress(
            time=None if self._start is None else (stamp - self._start) * 1e-9,
            engaged=None if engaged is None else engaged.data,
            range=float(np.linalg.norm(motion.position - position)),
            altitude=float(motion.position[2] - position[2]),
            speed=math.hypot(*velocity),
            solve_time=float("nan") if solve_time is None else solve_time.data,
        )

    def _message(self, topic: Topic) -> Any:
        data = self._latest.get(topic.name)
        return None if data is None else deserialize_message(data, topic.type)
