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

"""Node ``observer``: hears both sides of every topic, checks the invariants, keeps the messages.

It reads the messages itself: nothing of the controller's own code is between the wire and the
judgement. Those of a case that failed are written as an MCAP bag.
"""

from __future__ import annotations

import functools
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from uav_tracking_mpc.nodes.flight_recorder import FlightBag
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY, TARGET, Topic
from uav_tracking_mpc.studies.faults.invariants import Invariants, Limits, Recovery, Violation
from uav_tracking_mpc.studies.faults.stream_fault import ORDERS, STREAMS, raw

MOST = 100_000  # messages; a case has a tenth of it
BEFORE = 1_000_000_000  # ns of what came before the case

# Of a bag; of every relayed topic both sides: as sent (under ``raw``) and as received.
TOPICS = (*(raw(topic) for topic in STREAMS), *STREAMS, DIAGNOSTICS, ORDERS)
QUEUE = 1000  # messages that may wait
PATIENCE = 1.0  # s of simulated time without a command after which the aircraft is not commanded


class Observer(Node):
    """Hears every message of a campaign.

    Args:
        limits: What the messages are held to.
        orbit: Range and altitude to be on [m].
        recovery: Told of every state.
        violations: Where those that are found are added.
        relayed: Whether a relay stands in the way of every topic.
        options: As of rclpy's Node.

    Attributes:
        commands: How many were sent.
        longest_gap: Greatest time between the states of two commands [s].
        heard: Steady time [s] of each node's latest diagnostics, by its name.
    """

    def __init__(
        self,
        limits: Limits,
        orbit: tuple[float, float],
        recovery: Recovery,
        violations: list[Violation],
        relayed: bool = True,
        **options: Any,
    ) -> None:
        super().__init__("observer", **options)
        self._invariants, self._recovery = Invariants(limits), recovery
        self._violations, self._orbit = violations, orbit
        self._target: np.ndarray | None = None
        self._answered = math.nan  # stamp of the state of the latest command [s]
        self._commanded = -math.inf  # flown time of the latest command [s]
        self._messages: deque[tuple[Topic, int, bytes]] = deque(maxlen=MOST)
        self.commands, self.longest_gap = 0, 0.0
        self.heard: dict[str, float] = {}
        sent = {each: raw(each) if relayed else each for each in STREAMS}
        judges = [
            (sent[ODOMETRY], self._on_state),
            (ODOMETRY, self._on_delivered),
            (sent[TARGET], self._on_target),
            (sent[COMMAND], self._on_command),
            (DIAGNOSTICS, self._on_diagnostics),
        ]
        for topic in dict.fromkeys((*sent.values(), *STREAMS, DIAGNOSTICS)):
            those = [judge for judged, judge in judges if judged == topic]
            callback = functools.partial(self._on_message, topic, those)
            FollowingSubscription(self, topic, callback, QUEUE, raw=True)

    def keep(self, topic: Topic, data: bytes) -> None:
        """Keep a message for the bag.

        Args:
            topic: On which it is sent.
            data: Serialized.
        """
        self._messages.append((topic, time.time_ns(), data))

    def _on_message(
        self, topic: Topic, judges: Sequence[Callable[[Any], None]], data: bytes
    ) -> None:
        self.keep(topic, data)
        message = deserialize_message(data, topic.type) if judges else None
        for judge in judges:
            judge(message)

    def _on_state(self, message: Any) -> None:
        position = vector(message.pose.pose.position)
        stamp = seconds(message.header.stamp)
        self._violations += self._invariants.state(stamp, position)
        range_error = altitude_error = math.nan
        if self._target is not None:
            offset, (wanted, altitude) = position - self._target, self._orbit
            range_error = float(np.linalg.norm(offset)) - wanted
            altitude_error = float(offset[2]) - altitude
        commanded = self._recovery.flown - self._commanded < PATIENCE
        self._recovery.state(stamp, range_error, altitude_error, commanded)

    def _on_delivered(self, message: Any) -> None:
        self._invariants.delivered(time.monotonic(), seconds(message.header.stamp))

    def _on_target(self, message: Any) -> None:
        self._target = vector(message.point)
        self._invariants.target(self._target)

    def _on_command(self, message: Any) -> None:
        plan, starts = read_command(message)
        stamp = seconds(message.header.stamp)
        self.commands += 1
        self.longest_gap = max(self.longest_gap, stamp - self._answered)
        self._answered, self._commanded = stamp, self._recovery.flown
        self._violations += self._invariants.command(time.monotonic(), stamp, plan, starts)

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            self.heard[status.name.partition(":")[0]] = time.monotonic()

    def begin_case(self) -> None:
        """Forget the messages that came more than a second ago."""
        while self._messages and self._messages[0][1] < time.time_ns() - BEFORE:
            self._messages.popleft()

    def write_bag(self, path: Path) -> None:
        """Write the messages of the present case as an MCAP file."""
        bag = FlightBag(path, TOPICS)
        for message in self._messages:
            bag.write(*message)
        bag.close()


def read_command(message: Any) -> tuple[np.ndarray, np.ndarray]:
    """Plan of a command, read without the controller's own code.

    Args:
        message: MultiDOFJointTrajectory.

    Returns:
        (u_psi, u_chi, u_v) of every point, shape (n, 3), in [rad/s, rad/s, m/s^2], nan where it
        has none; when each begins after the stamp, shape (n,) [s].
    """
    plan = np.full((len(message.points), 3), np.nan)
    starts = np.zeros(len(message.points))
    for index, point in enumerate(message.points):
        starts[index] = seconds(point.time_from_start)
        if point.velocities and point.accelerations:
            # FLU pitch is positive nose down: the path-angle rate is minus the pitch rate.
            rates, acceleration = point.velocities[0].angular, point.accelerations[0].linear
            plan[index] = rates.z, -rates.y, acceleration.x
    return plan, starts


def seconds(stamp: Any) -> float:
    """A stamp as one number [s].

    Args:
        stamp: Of a message.
    """
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def vector(message: Any) -> np.ndarray:
    """A point or vector as an array, shape (3,), in the [unit] of the message.

    Args:
        message: With x, y and z.
    """
    return np.array([message.x, message.y, message.z], dtype=float)
