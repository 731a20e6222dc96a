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

"""Every aircraft of a domain, for who only looks; and requests to the nodes of one of them.

Who only looks must not slow down who flies: subscriptions are best effort, which connects with
every publisher, and what comes is kept as it came and read when it is looked at. A node that flies
is asked for its parameters once, and again when it says that they have changed.
"""

from __future__ import annotations

import functools
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray
from rcl_interfaces.msg import ParameterEvent
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import qos_profile_parameter_events
from rclpy.serialization import deserialize_message
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import set_vector
from uav_tracking_mpc.nodes.messages.heard_values import VALUES, NodeReport
from uav_tracking_mpc.nodes.messages.wires import deserialized, planned_places
from uav_tracking_mpc.nodes.ros.declared_parameters import ros_value
from uav_tracking_mpc.nodes.ros.endpoints import (
    FollowingSubscription,
    NewestMessage,
    namespaces,
    steady_timer,
)
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ANY_FRAMES,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_GOAL,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    TRACKING_ERRORS,
    Topic,
)
from uav_tracking_mpc.parameters.specification import (
    ParameterError,
    Parameters,
    from_mapping,
    specifications,
)
from uav_tracking_mpc.settings.tracking import TrackingParameters

T = TypeVar("T", bound=Parameters)
CONTROLLER = "nmpc_controller"
EVENTS = "/parameter_events"
LIMIT = 5.0  # s of wall time for an answer
LOOK_PERIOD = 0.5  # s between looks for aircraft
QUEUE = 50  # reports that may wait: several aircraft send them on one topic


def asking_node(context: Context) -> Node:
    """A node for requests alone.

    Args:
        context: Of rclpy, in the domain that is asked.
    """
    return Node("uav_tracking", context=context, start_parameter_services=False)


class NoAnswerError(RuntimeError):
    """A node is not there, or did not answer in time; the message names it."""


class RemoteParameters:
    """The parameters of another node, read and set by its services without waiting.

    A node that flies is asked for its parameters once, and again when it says that they have
    changed: to answer takes it time.

    Args:
        node: That asks.
        remote: Name of the node that is asked, with its namespace.

    Attributes:
        remote: Its name.
        values: By name; None before they were read, and once they have changed.
    """

    def __init__(self, node: Node, remote: str) -> None:
        self._client = AsyncParameterClient(node, remote)
        self.remote = remote
        self.values: dict[str, Any] | None = None
        self._changes = 0

    @property
    def offered(self) -> bool:
        """Whether the node is there; one that was killed counts for some seconds."""
        return self._client.services_are_ready()

    def forget(self) -> None:
        """They have changed: what is read from now on counts."""
        self._changes += 1
        self.values = None

    def read(self) -> Future[dict[str, Any] | None]:
        """Ask for all of them; the result is None where the node ended meanwhile."""
        changes = self._changes
        read: Future[dict[str, Any] | None] = Future()

        def on_names(listed: Future[Any]) -> None:
            if (answer := _result(listed)) is None:
                read.set_result(None)
            else:
                names = list(answer.result.names)
                self._client.get_parameters(names, lambda got: on_values(names, got))

        def on_values(names: list[str], got: Future[Any]) -> None:
            answer, values = _result(got), None
            if answer is not None:
                said = map(parameter_value_to_python, answer.values)
                values = dict(zip(names, said, strict=False))  # none where one has gone meanwhile
                if changes == self._changes and len(values) == len(names):
                    self.values = values
            read.set_result(values)

        self._client.list_parameters(callback=on_names)
        return read

    def set(self, values: Mapping[str, Any]) -> Future[Any]:
        """Ask for values as a whole; the result says ``successful``, or the ``reason`` why not.

        Args:
            values: By name.
        """
        return self._client.set_parameters_atomically(
            [Parameter(name, value=ros_value(value)) for name, value in values.items()]
        )


class FollowedParameters(Generic[T]):
    """The parameters of another node as a dataclass, read again whenever they have changed.

    Args:
        node: That asks.
        remote: Name of the node that is asked, with its namespace.
        kind: The dataclass; parameters that it does not have are left out.

    Attributes:
        value: The parameters; None before they are known.
        trouble: Why its latest answer cannot be used, in words; empty if it can.
    """

    def __init__(self, node: Node, remote: str, kind: type[T]) -> None:
        self._remote, self._kind = RemoteParameters(node, remote), kind
        self._logger, self._asked = node.get_logger(), -LIMIT  # and when, steady [s]
        self.value: T | None = None
        self.trouble = ""

    def follow(self) -> None:
        """Ask the node if it must be, and can be; called about once a second."""
        now, remote = time.monotonic(), self._remote
        if remote.values is None and now - self._asked >= LIMIT and remote.offered:
            self._asked = now
            remote.read().add_done_callback(self._on_read)

    def see(self, event: ParameterEvent) -> None:
        """Ask again where parameters of the node have changed.

        Args:
            event: Of ``/parameter_events``.
        """
        if event.node == self._remote.remote:
            self._remote.forget()
            self._asked = -LIMIT
            self.follow()

    def _on_read(self, _: Future[Any]) -> None:
        if (values := self._remote.values) is None:
            return
        known = {name: value for name, value in values.items() if value is not None}
        try:
            kind = self._kind.extended(known)
            names = {specification.name for specification in specifications(kind)}
            self.value = from_mapping(kind, {k: v for k, v in known.items() if k in names})
            self.trouble = ""
        except (ParameterError, ImportError) as error:
            self.trouble = f"parameters of {self._remote.remote}: {error}"
            self._logger.warning(self.trouble)


class SteeringRequests:
    """What can be asked of the nodes of an aircraft. Every request waits for its answer.

    Args:
        node: That asks, in an executor that is spun in a thread of its own.
        namespace: Of the aircraft, with or without slashes at its ends; empty for none.
        owners: Nodes whose parameters are asked for.
        switches: Services of type SetBool, each as ``node/service``.
        triggers: Services of type Trigger, each as ``node/service``.
    """

    def __init__(
        self,
        node: Node,
        namespace: str,
        owners: Sequence[str],
        switches: Sequence[str],
        triggers: Sequence[str],
    ) -> None:
        self._namespace = namespace.strip("/")
        self._owners = {owner: RemoteParameters(node, self._absolute(owner)) for owner in owners}
        kinds = dict.fromkeys(switches, SetBool) | dict.fromkeys(triggers, Trigger)
        self._services = {
            service: node.create_client(kind, self._absolute(service))
            for service, kind in kinds.items()
        }
        node.create_subscription(
            ParameterEvent, EVENTS, self._on_event, qos_profile_parameter_events
        )
        self._goals = node.create_publisher(
            TARGET_GOAL.type, self._absolute(TARGET_GOAL.name), TARGET_GOAL.qos
        )
        self._truth = NewestMessage(
            node,
            replace(TARGET_TRUTH, name=self._absolute(TARGET_TRUTH.name)),
            lambda data: deserialize_message(data, TARGET_TRUTH.type),
        )

    def _absolute(self, name: str) -> str:
        return "/" + "/".join(filter(None, (self._namespace, name)))

    def _on_event(self, event: ParameterEvent) -> None:
        for parameters in self._owners.values():
            if parameters.remote == event.node:
                parameters.forget()

    def offered(self, name: str) -> bool:
        """Whether somebody is there now; one that was killed counts for some seconds.

        Args:
            name: An owner of parameters, or a service as ``node/service``.
        """
        if name in self._owners:
            return self._owners[name].offered
        return bool(self._services[name].service_is_ready())

    def _make_sure(self, name: str) -> None:
        if not self.offered(name):
            raise NoAnswerError(f"{name.partition('/')[0]} is not there")

    def parameters(self, owner: str) -> dict[str, Any]:
        """Values of a node's parameters by name.

        Args:
            owner: The node.

        Raises:
            NoAnswerError: It did not answer.
        """
        self._make_sure(owner)
        known = self._owners[owner].values
        return dict(_answer(owner, self._owners[owner].read()) if known is None else known)

    def change(self, owner: str, values: Mapping[str, Any]) -> str:
        """Set parameters of a node as a whole, or not at all.

        Args:
            owner: The node.
            values: By name.

        Returns:
            Why they were refused, in the node's own words; empty where they were set.

        Raises:
            NoAnswerError: It did not answer.
        """
        self._make_sure(owner)
        result = _answer(owner, self._owners[owner].set(values)).result
        self._owners[owner].forget()  # what it says of itself may come later than its answer
        return "" if result.successful else result.reason or f"{owner} refused without a reason"

    def call(self, service: str, **request: Any) -> str:
        """Call a service of type SetBool or Trigger.

        Args:
            service: As ``node/service``.
            request: ``data`` of a SetBool.

        Returns:
            Why it was refused, in the node's own words; empty where it was done.

        Raises:
            NoAnswerError: It did not answer.
        """
        self._make_sure(service)
        client = self._services[service]
        future = client.call_async(client.srv_type.Request(**request))
        answer = _answer(service.partition("/")[0], future)
        return "" if answer.success else answer.message or f"{service} refused without a reason"

    def send_goal(self, east: float, north: float) -> tuple[float, float, float] | None:
        """Publish where the target is to go, at the height that it has.

        Args:
            east: In ``map`` in [m].
            north: In ``map`` in [m].

        Returns:
            The goal in ``map`` in [m]; None where nobody says how high the target is.
        """
        if (truth := self._truth.value) is None:
            return None
        goal = (float(east), float(north), float(truth.pose.pose.position.z))
        message = TARGET_GOAL.type()
        message.header.frame_id = truth.header.frame_id
        set_vector(message.point, np.array(goal))
        self._goals.publish(message)
        return goal


def _result(future: Future[Any]) -> Any:
    """What was answered; None where nothing was, as when the node ended meanwhile."""
    return None if future.cancelled() or future.exception() else future.result()


def _answer(owner: str, future: Future[Any]) -> Any:
    """What a node answers, waited for in another thread than the one that spins the node."""
    done = threading.Event()
    future.add_done_callback(lambda _: done.set())
    answer = _result(future) if done.wait(LIMIT) else None
    if answer is None:
        raise NoAnswerError(f"{owner} did not answer within {LIMIT:g} s")
    return answer


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
        self._node = node
        self.state: NewestMessage[Measurement] = self._hear(ODOMETRY)
        self.plan: NewestMessage[Plan] = self._hear(COMMAND, _plan)
        self.airspeed: NewestMessage[float] = self._hear(AIR_VELOCITY)
        self.sighting: NewestMessage[NDArray[np.float64]] = self._hear(TARGET)
        self.tracked: NewestMessage[NDArray[np.float64]] = self._hear(TARGET_ODOMETRY)
        self.truth: NewestMessage[NDArray[np.float64]] = self._hear(TARGET_TRUTH)
        self.orbit: NewestMessage[FlownOrbit] = self._hear(ORBIT)
        self.figures: NewestMessage[dict[str, float]] = self._hear(TRACKING_ERRORS)
        self.cost: NewestMessage[float] = self._hear(TRACKING["cost"])
        self.solve_time: NewestMessage[float] = self._hear(TRACKING["solve_time"])
        self.reports: dict[str, NodeReport] = {}

    def _hear(self, topic: Topic, read: Callable[[bytes], Any] | None = None) -> NewestMessage[Any]:
        name = f"{self.namespace.rstrip('/')}/{topic.name}"
        read = functools.partial(_read, topic) if read is None else read
        return NewestMessage(self._node, replace(topic, name=name), read)

    def report(self, said: NodeReport) -> None:
        """Take in what one of its nodes says of itself.

        Args:
            said: Of ``/diagnostics``.
        """
        node = said.path.removeprefix(self.namespace).strip("/")
        # One step, for another thread looks: what it goes through is not changed.
        self.reports = {**self.reports, node: said._replace(node=node, arrival=time.monotonic())}


def _plan(data: bytes) -> Plan:
    stamp, positions, times = planned_places(data, ANY_FRAMES)
    return Plan(stamp * 1e-9, positions, times)


def _read(topic: Topic, data: bytes) -> Any:
    """What the bytes of a message say."""
    return VALUES[topic.name](deserialized(topic, data))


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
        steady_timer(self, LOOK_PERIOD, self._look)

    def _look(self) -> None:
        """Listen to aircraft that are new, and ask controllers that have changed."""
        for namespace in sorted(namespaces(self) - self.aircraft.keys()):
            self._listen(namespace)
        for parameters in self.parameters.values():
            parameters.follow()

    def _listen(self, namespace: str) -> None:
        controller = f"{namespace.rstrip('/')}/{CONTROLLER}"
        asked = FollowedParameters(self, controller, TrackingParameters)
        self.parameters = {**self.parameters, namespace: asked}
        self.aircraft = {**self.aircraft, namespace: HeardAircraft(self, namespace)}

    def _on_diagnostics(self, message: Any) -> None:
        for said in VALUES[DIAGNOSTICS.name](message):
            if (heard := self._whose(said.path)) is not None:
                heard.report(said)

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
