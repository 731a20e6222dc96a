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

"""What is heard of one aircraft, its controller and its target, for who only looks."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.serialization import deserialize_message

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.command_wire import CommandWire
from uav_tracking_mpc.nodes.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    position_from_point,
)
from uav_tracking_mpc.nodes.frame_names import ANY_FRAMES
from uav_tracking_mpc.nodes.message_checks import MessageError
from uav_tracking_mpc.nodes.newest_message import NewestMessage
from uav_tracking_mpc.nodes.odometry_wire import OdometryWire
from uav_tracking_mpc.nodes.orbit_message import orbit_from_message
from uav_tracking_mpc.nodes.target_odometry import TargetMeasurement, target_from_odometry
from uav_tracking_mpc.nodes.target_truth import truth_from_odometry
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    TRACKING_ERRORS,
    Topic,
)
from uav_tracking_mpc.nodes.tracking_message import tracking_figures

T = TypeVar("T")


class Plan(NamedTuple):
    """Where a command leads.

    Attributes:
        stamp: Of the state that it answers in [s].
        positions: In ``map``, shape (n, 3), in [m]; n = 0 where it does not say.
        times: Since the stamp, shape (n,), in [s].
    """

    stamp: float
    positions: NDArray[np.float64]
    times: NDArray[np.float64]


@dataclass(frozen=True)
class Report:
    """What a node says of itself.

    Attributes:
        node: Its name without its namespace.
        level: 0 ok, 1 warning, 2 error, 3 stale.
        words: What people read.
        values: Keys with units, and figures.
        arrival: When it came, steady, in [s].
    """

    node: str
    level: int
    words: str
    values: Mapping[str, str]
    arrival: float


class HeardAircraft:
    """The newest of each topic of one namespace.

    Args:
        node: That listens.
        namespace: Absolute, such as ``/red``; ``/`` for none.

    Attributes:
        namespace: Absolute.
        state: Of the aircraft, stamped in [s].
        airspeed: Measured, in [m/s].
        sighting: Where the target was measured in ``map``, shape (3,), in [m].
        tracked: What a tracker says of the target instead.
        truth: Where the target truly is in ``map``, shape (3,), in [m].
        plan: Where the newest command leads.
        orbit: What it leads to.
        figures: What the controller tracks by, by name: see ``tracking_message``.
        cost: Of the newest plan [-].
        solve_time: Of it in [s].
        reports: What the nodes say of themselves, by their names without the namespace.
    """

    def __init__(self, node: Node, namespace: str) -> None:
        self.namespace = namespace
        self._node, self._odometry, self._commands = node, OdometryWire(), CommandWire(ANY_FRAMES)
        self.state = self._hear(ODOMETRY, self._state)
        self.airspeed = self._hear(AIR_VELOCITY, _of(AIR_VELOCITY, _airspeed))
        self.sighting = self._hear(TARGET, _of(TARGET, _sighting))
        self.tracked = self._hear(TARGET_ODOMETRY, _of(TARGET_ODOMETRY, _tracked))
        self.truth = self._hear(TARGET_TRUTH, _of(TARGET_TRUTH, _truth))
        self.plan = self._hear(COMMAND, self._plan)
        self.orbit = self._hear(ORBIT, _of(ORBIT, _orbit))
        self.figures = self._hear(TRACKING_ERRORS, _of(TRACKING_ERRORS, tracking_figures))
        self.cost, self.solve_time = (
            self._hear(TRACKING[name], _of(TRACKING[name], _number))
            for name in ("cost", "solve_time")
        )
        self.reports: dict[str, Report] = {}

    def _hear(self, topic: Topic, read: Callable[[bytes], T]) -> NewestMessage[T]:
        name = f"{self.namespace.rstrip('/')}/{topic.name}"
        return NewestMessage(self._node, replace(topic, name=name), read)

    def report(self, status: DiagnosticStatus) -> None:
        """Take in what one of its nodes says of itself.

        Args:
            status: Of ``/diagnostics``.
        """
        node = status.name.partition(":")[0].removeprefix(f"{self.namespace.strip('/')}/")
        values = {entry.key: entry.value for entry in status.values}
        level = int.from_bytes(status.level, "little")
        # One step, for another thread looks: what it goes through is not changed.
        self.reports = {
            **self.reports,
            node: Report(node, level, status.message, values, time.monotonic()),
        }

    def _state(self, data: bytes) -> Measurement:
        message = self._odometry.read(data)
        stamp = nanoseconds(message.header.stamp) * 1e-9
        return measurement_from_odometry(message, stamp, ANY_FRAMES)

    def _plan(self, data: bytes) -> Plan:
        stamp, positions, times = self._commands.places(data)
        return Plan(stamp * 1e-9, positions, times)


def _of(topic: Topic, said: Callable[[Any], T]) -> Callable[[bytes], T]:
    """From the bytes of a message to what it says."""

    def read(data: bytes) -> T:
        try:
            message = deserialize_message(data, topic.type)
        except Exception as error:  # whatever the middleware says of bytes that are no message
            raise MessageError(f"{topic.name}: no message: {error}") from error
        return said(message)

    return read


def _airspeed(message: Any) -> float:
    return math.hypot(*air_velocity_from_twist(message, ANY_FRAMES))


def _sighting(message: Any) -> NDArray[np.float64]:
    return position_from_point(message, ANY_FRAMES)


def _tracked(message: Any) -> TargetMeasurement:
    return target_from_odometry(message, ANY_FRAMES)


def _truth(message: Any) -> NDArray[np.float64]:
    _, position, _ = truth_from_odometry(message)
    if not np.isfinite(position).all():
        raise MessageError(f"{TARGET_TRUTH.name}: position is {position.tolist()}, must be finite")
    return position


def _orbit(message: Any) -> FlownOrbit:
    return orbit_from_message(message, ANY_FRAMES)


def _number(message: Any) -> float:
    return float(message.data)
