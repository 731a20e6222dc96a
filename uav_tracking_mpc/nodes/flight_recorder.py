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
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from uav_tracking_mpc.nodes.bag.flight_bag import FlightBag
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.messages.heard_values import VALUES
from uav_tracking_mpc.nodes.messages.wires import deserialized
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription, steady_timer
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ALL,
    COMMAND,
    ENGAGED,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
    MessageError,
    Topic,
)

SHOWN = (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY, ENGAGED, TRACKING["solve_time"])
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
    range: float = math.nan
    altitude: float = math.nan
    speed: float = math.nan
    solve_time: float = math.nan


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
        self._waiting = steady_timer(self, 0.05, self._release)

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

    def progress(self) -> Progress:
        """Where the flight stands by the latest messages."""
        try:
            state, airspeed, place, tracked, engaged, solve_time = map(self._said, SHOWN)
        except MessageError:
            return Progress()
        if state is None:
            return Progress()
        seen = (where for where in (place, tracked) if where is not None)
        target = next(seen, np.full(3, math.nan))
        return Progress(
            time=None if self._start is None else state.stamp - self._start * 1e-9,
            engaged=engaged,
            range=float(np.linalg.norm(state.position - target)),
            altitude=float(state.position[2] - target[2]),
            speed=math.hypot(*state.ground_velocity) if airspeed is None else airspeed,
            solve_time=math.nan if solve_time is None else solve_time,
        )

    def _said(self, topic: Topic) -> Any:
        """What the latest message of a topic says; None before the first."""
        data = self._latest.get(topic.name)
        return None if data is None else VALUES[topic.name](deserialized(topic, data))
