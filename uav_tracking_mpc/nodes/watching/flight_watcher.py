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

"""Every aircraft of a domain, for who only looks: what is heard of each.

Who only looks must not slow down who flies: subscriptions are best effort, which connects with
every publisher, and what comes is kept as it came and read when it is looked at.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from numpy.typing import NDArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.qos import qos_profile_parameter_events
from rclpy.serialization import deserialize_message

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.heard_values import VALUES
from uav_tracking_mpc.nodes.messages.message_checks import ANY_FRAMES, MessageError
from uav_tracking_mpc.nodes.messages.wires import CommandWire, OdometryWire
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription, NewestMessage
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    TRACKING_ERRORS,
    Topic,
)
from uav_tracking_mpc.nodes.watching.steering_requests import FollowedParameters
from uav_tracking_mpc.settings.tracking import TrackingParameters


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
        tracked: Where a tracker says that the target is instead, as ``sighting``.
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
        self.state: NewestMessage[Measurement] = self._hear(ODOMETRY, self._state)
        self.plan: NewestMessage[Plan] = self._hear(COMMAND, self._plan)
        self.airspeed: NewestMessage[float] = self._hear(AIR_VELOCITY)
        self.sighting: NewestMessage[NDArray[np.float64]] = self._hear(TARGET)
        self.tracked: NewestMessage[NDArray[np.float64]] = self._hear(TARGET_ODOMETRY)
        self.truth: NewestMessage[NDArray[np.float64]] = self._hear(TARGET_TRUTH)
        self.orbit: NewestMessage[FlownOrbit] = self._hear(ORBIT)
        self.figures: NewestMessage[dict[str, float]] = self._hear(TRACKING_ERRORS)
        self.cost: NewestMessage[float] = self._hear(TRACKING["cost"])
        self.solve_time: NewestMessage[float] = self._hear(TRACKING["solve_time"])
        self.reports: dict[str, Report] = {}

    def _hear(self, topic: Topic, read: Callable[[bytes], Any] | None = None) -> NewestMessage[Any]:
        name = f"{self.namespace.rstrip('/')}/{topic.name}"
        read = functools.partial(_read, topic) if read is None else read
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
        state: Measurement = VALUES[ODOMETRY.name](self._odometry.read(data))
        return state

    def _plan(self, data: bytes) -> Plan:
        stamp, positions, times = self._commands.places(data)
        return Plan(stamp * 1e-9, positions, times)


def _read(topic: Topic, data: bytes) -> Any:
    """What the bytes of a message say."""
    try:
        message = deserialize_message(data, topic.type)
    except Exception as error:  # whatever the middleware says of bytes that are no message
        raise MessageError(f"{topic.name}: no message: {error}") from error
    return VALUES[topic.name](message)


CONTROLLER = "nmpc_controller"
LOOK_PERIOD = 0.5  # s between looks for aircraft
QUEUE = 50  # reports that may wait: several aircraft send them on one topic
EVENTS = "/parameter_events"


class FlightWatcher(Node):
    """Keeps what each aircraft, its controller and its target said last.

    An aircraft is wherever somebody publishes ``uav/odometry``; it stays when it falls silent.

    Args:
        options: Of rclpy's Node.

    Attributes:
        aircraft: By namespace, absolute.
        parameters: Of their controllers, by namespace.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("flight_watcher", start_parameter_services=False, **options)
        # Another thread looks: both are replaced, never changed.
        self.aircraft: dict[str, HeardAircraft] = {}
        self.parameters: dict[str, FollowedParameters[TrackingParameters]] = {}
        FollowingSubscription(self, DIAGNOSTICS, self._on_diagnostics, QUEUE)
        self.create_subscription(
            ParameterEvent, EVENTS, self._on_change, qos_profile_parameter_events
        )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(LOOK_PERIOD, self._look, clock=steady)

    def _look(self) -> None:
        """Listen to aircraft that are new, and ask controllers that have changed."""
        suffix = f"/{ODOMETRY.name}"
        for topic, _ in self.get_topic_names_and_types():
            namespace = topic.removesuffix(suffix) or "/"
            known = namespace in self.aircraft or not topic.endswith(suffix)
            if not known and self.count_publishers(topic):
                self._listen(namespace)
        for parameters in self.parameters.values():
            parameters.follow()

    def _listen(self, namespace: str) -> None:
        controller = f"{namespace.rstrip('/')}/{CONTROLLER}"
        asked = FollowedParameters(self, controller, TrackingParameters)
        self.parameters = {**self.parameters, namespace: asked}
        self.aircraft = {**self.aircraft, namespace: HeardAircraft(self, namespace)}

    def _on_diagnostics(self, message: Any) -> None:
        for status in message.status:
            path = f"/{status.name.partition(':')[0]}"
            if (heard := self._whose(path)) is not None:
                heard.report(status)

    def _whose(self, path: str) -> HeardAircraft | None:
        """The aircraft to which a node belongs: that of the longest namespace it is in."""
        namespace = path
        while namespace:
            namespace = namespace.rpartition("/")[0]
            if (heard := self.aircraft.get(namespace or "/")) is not None:
                return heard
        return None

    def _on_change(self, event: ParameterEvent) -> None:
        for parameters in self.parameters.values():
            parameters.see(event)
