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

"""Publishers and subscriptions of topics: made, checked, counted, and such as only look.

rclpy ends in a traceback on a value of ``qos_overrides.TOPIC.publisher|subscription.POLICY`` that
it does not know, and ignores an override that no endpoint asks for: both are told in words here.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import HistoryPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from rclpy.subscription import Subscription
from rclpy.timer import Timer
from std_srvs.srv import Trigger

from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.nodes.ros.rclpy_internals import declared_parameters, parameter_overrides
from uav_tracking_mpc.nodes.topics import ODOMETRY, SENSED, Topic
from uav_tracking_mpc.parameters.specification import ParameterError

T = TypeVar("T")
PREFIX = "qos_overrides."
PUBLISHER, SUBSCRIPTION = "publisher", "subscription"
POLICIES = {"history": HistoryPolicy, "reliability": ReliabilityPolicy}  # and depth
DEPTH_MAX = 10_000  # messages that a queue may hold


def overriding_options(node: Node, topic: str, kind: str) -> QoSOverridingOptions:
    """What rclpy takes, once the overrides of an endpoint have been checked.

    Args:
        node: Whose endpoint it is.
        topic: Name of the topic as the node knows it.
        kind: PUBLISHER or SUBSCRIPTION.

    Raises:
        ParameterError: An override is not allowed.
    """
    overrides = parameter_overrides(node)
    begin = f"{PREFIX}{node.resolve_topic_name(topic)}.{kind}."
    for policy, values in POLICIES.items():
        name = f"{begin}{policy}"
        allowed = [each.name.lower() for each in values if each.name != "UNKNOWN"]
        if name in overrides and str(overrides[name]).lower() not in allowed:
            raise _error(name, overrides[name], f"one of {', '.join(allowed)}")
    name = f"{begin}depth"
    depth = overrides.get(name, 1)
    if isinstance(depth, bool) or not (isinstance(depth, int) and 1 <= depth <= DEPTH_MAX):
        raise _error(name, depth, f"an integer from 1 to {DEPTH_MAX}")
    return QoSOverridingOptions.with_default_policies()


def warn_of_vain_overrides(node: Node) -> None:
    """Warn of overrides that no endpoint of a node has taken.

    Args:
        node: With all its publishers and subscriptions.
    """
    for name in parameter_overrides(node):
        if name.startswith(PREFIX) and not node.has_parameter(name):
            known = [each for each in declared_parameters(node) if each.startswith(PREFIX)]
            node.get_logger().warning(
                f"parameter '{name}' is unknown and has no effect; known are: {', '.join(known)}"
            )


def _error(name: str, value: Any, allowed: str) -> ParameterError:
    return ParameterError(f"parameter '{name}' is {value!r}, must be {allowed}")


def publish(
    node: Node,
    topic: Topic,
    qos: QoSProfile | None = None,
    event_callbacks: PublisherEventCallbacks | None = None,
) -> Publisher[Any]:
    """A publisher of a topic.

    Args:
        node: That publishes.
        topic: What is published.
        qos: Instead of the topic's own, where the node promises more.
        event_callbacks: As rclpy takes them.

    Raises:
        ParameterError: An override is not allowed.
    """
    return node.create_publisher(
        topic.type,
        topic.name,
        qos or topic.qos,
        event_callbacks=event_callbacks,
        qos_overriding_options=overriding_options(node, topic.name, PUBLISHER),
    )


def listen(
    node: Node,
    topic: Topic,
    callback: Callable[[Any], None],
    event_callbacks: SubscriptionEventCallbacks | None = None,
    raw: bool = False,
) -> Subscription[Any]:
    """A subscription of a topic.

    Args:
        node: That listens.
        topic: What is listened to.
        callback: Called with each message.
        event_callbacks: As rclpy takes them.
        raw: Whether it is called with the message as bytes.

    Raises:
        ParameterError: An override is not allowed.
    """
    return node.create_subscription(
        topic.type,
        topic.name,
        callback,
        topic.heard,
        event_callbacks=event_callbacks,
        qos_overriding_options=overriding_options(node, topic.name, SUBSCRIPTION),
        raw=raw,
    )


def steady_timer(node: Node, period: float, callback: Callable[[], None]) -> Timer:
    """A timer by the steady clock, which goes on while simulated time stands.

    Args:
        node: Whose timer it is.
        period: In [s].
        callback: Called each time.
    """
    return node.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def namespaces(node: Node) -> set[str]:
    """Absolute namespaces of all aircraft: where somebody publishes a state.

    Args:
        node: That looks.
    """
    suffix = f"/{ODOMETRY.name}"
    return {
        name.removesuffix(suffix) or "/"
        for name, _ in node.get_topic_names_and_types()
        if name.endswith(suffix) and node.count_publishers(name)
    }


OUTAGE = 15.0  # s of the node's time: longer than a plan, and than the target's default timeout
LEASE = 1.0  # s in which a publisher says that it is alive, for those who ask for it
LATE = 2.0  # -, periods from message to message, beyond which the deadline is missed


class PublisherWatch:
    """Publishers that a node listens to.

    Args:
        node: That listens.
        lost: Called with words when the last publisher of a topic is gone.
    """

    def __init__(self, node: Node, lost: Callable[[str], None]) -> None:
        self._node, self._lost = node, lost
        self._counts: dict[str, int] = {}

    def listen(self, topic: Topic, callback: Callable[[Any], None], raw: bool = False) -> None:
        """Subscribe to a topic, and count its publishers.

        Args:
            topic: What is listened to.
            callback: Called with each message.
            raw: Whether it is called with the message as bytes.
        """
        self._counts[topic.name] = 0

        def matched(event: Any) -> None:
            self._counts[topic.name] = event.current_count
            if event.current_count == 0 and event.current_count_change < 0:
                self._lost(f"nobody publishes {topic.name} any more")

        listen(self._node, topic, callback, SubscriptionEventCallbacks(matched=matched), raw)

    def values(self) -> dict[str, object]:
        """For /diagnostics."""
        return {f"publishers of {name}": count for name, count in self._counts.items()}


class PacedPublisher:
    """A publisher that promises a rate, in wall time.

    Args:
        node: That publishes.
        topic: What is published.
        rate: Messages a second in [Hz]; None in simulated time, of which the wall clock says
            nothing.
        late: Called when the next message is too late.

    Attributes:
        publisher: The publisher itself.
        rate: Messages a second that are meant to be sent in [Hz]; a lower one than offered is no
            message too late.
        missed: How often the next message was too late.
    """

    def __init__(
        self, node: Node, topic: Topic, rate: float | None, late: Callable[[], None] = lambda: None
    ) -> None:
        self.rate = self._offered = rate or 0.0
        self._late, self.missed = late, 0
        qos = QoSProfile(
            depth=topic.qos.depth,
            reliability=topic.qos.reliability,
            liveliness=LivelinessPolicy.AUTOMATIC,
            liveliness_lease_duration=Duration(seconds=LEASE),
            deadline=Duration(seconds=LATE / rate) if rate else Duration(),
        )
        events = PublisherEventCallbacks(deadline=self._on_missed if rate else None)
        self.publisher = publish(node, topic, qos, events)

    def _on_missed(self, event: object) -> None:
        if self.rate >= self._offered:
            self.missed += 1
            self._late()


class SimulatedOutage:
    """Service ``~/lose_...`` (std_srvs/Trigger): it begins an outage that ends by itself.

    Whoever asked for it need not be there at its end. Asked again, it lasts from then on.

    Args:
        node: That keeps something back.
        service: Name of the service, without the node's.
        what: That is kept back, in words.
        time: Time by which it lasts in [s].
    """

    def __init__(self, node: Node, service: str, what: str, time: Callable[[], float]) -> None:
        self._node, self._service, self._what, self._time = node, service, what, time
        self._begin: float | None = None
        node.create_service(Trigger, f"~/{service}", self._on_request)

    @property
    def lasts(self) -> bool:
        """Whether it goes on now; where time goes back before its begin, it is over."""
        return self._begin is not None and 0.0 <= self._time() - self._begin < OUTAGE

    @property
    def words(self) -> str:
        """What is kept back, and for how long."""
        return f"{self._what} is kept back for {OUTAGE:g} s by the service {self._service}"

    def _on_request(self, request: Any, response: Any) -> Any:
        self._begin = self._time()
        response.success, response.message = True, self.words
        self._node.get_logger().info(f"{self._service}: {self.words}")
        return response


class FollowingSubscription:
    """A subscription that follows the senders.

    Args:
        node: That listens.
        topic: What is listened to.
        callback: Called with each message.
        depth: How many messages may wait.
        raw: Whether it is called with the message as bytes.
    """

    def __init__(
        self,
        node: Node,
        topic: Topic,
        callback: Callable[[Any], None],
        depth: int,
        raw: bool = False,
    ) -> None:
        self._node, self._topic, self._callback = node, topic, callback
        self._depth, self._raw = depth, raw
        self._change: Any = None  # timer of a change that is due
        self._subscription = self._listen(ReliabilityPolicy.RELIABLE)

    @property
    def senders(self) -> int:
        """How many are connected."""
        return int(self._subscription.get_publisher_count())

    def _listen(self, reliability: ReliabilityPolicy) -> Any:
        reliable = reliability is ReliabilityPolicy.RELIABLE
        # Where a topic keeps what was sent before anybody listened, that is heard, too.
        durability = self._topic.qos.durability
        return self._node.create_subscription(
            self._topic.type,
            self._topic.name,
            self._callback,
            QoSProfile(depth=self._depth, reliability=reliability, durability=durability),
            event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=self._on_incompatible if reliable else None
            ),
            raw=self._raw,
        )

    def _on_incompatible(self, event: object) -> None:
        # The subscription cannot be destroyed while its own event is handled.
        if self._change is None:
            self._change = steady_timer(self._node, 0.0, self._follow)

    def _follow(self) -> None:
        self._change.cancel()
        before = self._subscription
        self._subscription = self._listen(ReliabilityPolicy.BEST_EFFORT)
        self._node.destroy_subscription(before)


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
        node.create_subscription(topic.type, topic.name, self._on_message, SENSED.profile, raw=True)

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
