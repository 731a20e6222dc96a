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

"""/diagnostics of a node, warnings that may come with every message, and doubled senders.

A worse status is shown at once. A better one, or another as bad, is shown once the present one has
not been reported for some seconds; at once if the present one had been reported alone for that
long. So a status that alternates twenty times a second is shown as the worse one.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.ros.endpoints import publish, steady_timer
from uav_tracking_mpc.nodes.ros.rclpy_internals import NumberedSubscription
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, Topic

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE  # of a node that has ended
LASTING = 2.0  # s, until a better status is shown


class SteadyStatus:
    """The status of a node.

    Until it was fine or erroneous for the first time every change is shown at once.

    Args:
        level: At the start, as of diagnostic_msgs.
        message: For people.

    Attributes:
        level: That is shown.
        message: That is shown.
        starting: Whether it has been neither fine nor erroneous yet.
    """

    def __init__(self, level: bytes, message: str) -> None:
        self.begin(level, message)

    def begin(self, level: bytes, message: str) -> None:
        """Show a status at once and begin anew.

        Args:
            level: As of diagnostic_msgs.
            message: For people.
        """
        self.level, self.message = level, message
        self.starting = level == WARN
        self._since = self._seen = -float("inf")
        self._alone = True  # whether nothing else was reported since it is shown

    def see(self, level: bytes, message: str, now: float) -> bool:
        """Take in how the node is.

        Args:
            level: As of diagnostic_msgs.
            message: For people.
            now: Time of a steady clock in [s].

        Returns:
            Whether another status is shown than before.
        """
        if (level, message) == (self.level, self.message):
            if not self._alone:
                self._alone, self._since = True, now
            self._seen = now
            return False
        ended = now - self._seen >= LASTING or (self._alone and now - self._since >= LASTING)
        self._alone = False
        if not (self.starting or level > self.level or level == self.level == OK or ended):
            return False
        self.level, self.message = level, message
        self._since, self._seen, self._alone = now, now, True
        self.starting = self.starting and level == WARN
        return True


STARTING = 3.0  # s for which it is ordinary at the start that something is not there yet
AIRCRAFT = "uav"  # the aircraft of nodes without a namespace


class Diagnostics:
    """Diagnostics of one node.

    The timer runs on a steady clock: a stopped simulation must not silence it. A status that
    changes with every message is shown as :class:`SteadyStatus` says. Until it was fine or
    erroneous for the first time, a warning is logged as information, and as a warning only if it
    stands for some seconds.

    Args:
        node: Whose they are.
        values: Called at each report for keys (with units) and values.
        now: Stamp of a report, by the node's clock unless the node itself makes the time.

    Attributes:
        hardware_id: Which aircraft it is: the namespace, or what its autopilot says of itself.
        status: That is shown.
    """

    def __init__(
        self,
        node: Node,
        values: Callable[[], Mapping[str, object]],
        now: Callable[[], Time] | None = None,
    ) -> None:
        self._node, self._values = node, values
        self._now = now or (lambda: node.get_clock().now().to_msg())
        self._name = f"{node.get_fully_qualified_name().lstrip('/')}: status"
        self.hardware_id = node.get_namespace().strip("/") or AIRCRAFT
        self.status = SteadyStatus(WARN, "starting")
        self._alarm = ""
        self._unlogged, self._since = "", 0.0  # a warning logged as information, and when [s]
        events = PublisherEventCallbacks(matched=self._on_listener)
        self._publisher = publish(node, DIAGNOSTICS, event_callbacks=events)
        steady_timer(node, 1.0, self._repeat)

    def report(self, level: bytes, message: str, reason: str = "") -> None:
        """Say how the node is; published and logged when another status is shown.

        Args:
            level: OK, WARN or ERROR.
            message: For people.
            reason: Added to the line in the log: why, with figures that may change.
        """
        if self.status.see(level, message, time.monotonic()):
            self._log(f"{message}: {reason}" if reason else message)
            self.publish()

    def announce(self, level: bytes, message: str) -> None:
        """Say how the node is from now on, because somebody asked for it; not logged.

        Args:
            level: OK, WARN or ERROR.
            message: For people.
        """
        self.status.begin(level, message)
        self._unlogged = ""
        self.publish()

    def end(self) -> None:
        """Publish the last values, and that nothing comes after them."""
        self._alarm = ""
        self.announce(STALE, "ended")

    def alarm(self, words: str) -> None:
        """Show an error in place of what is reported, as long as it lasts.

        Args:
            words: What is wrong; empty when it is over.
        """
        if words:
            self._node.get_logger().error(words)
        elif self._alarm:
            self._node.get_logger().info(f"over: {self._alarm}")
        self._alarm = words
        self.publish()

    def publish(self) -> None:
        """Publish the present state."""
        shown = self.status
        level, words = (ERROR, self._alarm) if self._alarm else (shown.level, shown.message)
        status = DiagnosticStatus(level=level, name=self._name, message=words)
        status.hardware_id = self.hardware_id
        try:
            values = self._values()
        except Exception as error:  # whatever a user's extension raises, the node goes on
            values = {"values": f"failed: {type(error).__name__}: {error}"}
        status.values = [
            KeyValue(key=key, value=f"{value:.6g}" if isinstance(value, float) else str(value))
            for key, value in values.items()
        ]
        message = DiagnosticArray(status=[status])
        message.header.stamp = self._now()
        self._publisher.publish(message)

    def _log(self, words: str) -> None:
        # rclpy ties each call site to one severity, hence one line each.
        logger, level, self._unlogged = self._node.get_logger(), self.status.level, ""
        if level == WARN and self.status.starting:
            self._unlogged, self._since = words, time.monotonic()
        if level == OK or self._unlogged:
            logger.info(words)
        elif level == WARN:
            logger.warning(words)
        else:
            logger.error(words)

    def _on_listener(self, event: Any) -> None:
        if event.current_count_change > 0:  # who begins to listen hears at once how the node is
            self.publish()

    def _repeat(self) -> None:
        if self._unlogged and time.monotonic() - self._since >= STARTING:
            self._node.get_logger().warning(self._unlogged)
            self._unlogged = ""
        self.publish()


PERIOD = 5.0  # s between warnings of one subject


class ThrottledWarnings:
    """The logger's own throttle is one for all topics: a stream of refusals would hide another's.

    Args:
        node: Whose log they are in.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._last: dict[str, float] = {}

    def warn(self, subject: str, words: str) -> None:
        """Log a warning unless one of its subject was logged just before.

        Args:
            subject: One of a few, such as the name of a topic.
            words: What there is to say.
        """
        now = time.monotonic()
        if now - self._last.get(subject, -PERIOD) >= PERIOD:
            self._last[subject] = now
            self._node.get_logger().warning(words)


LOOK_PERIOD = 1.0  # s between looks
WINDOW = 10.0  # s in which numbers fall often enough where two send
FALLS = 3  # in that time: more than restarts explain
UNNUMBERED = 30.0  # s that two publishers are known, where messages have no numbers
QUEUE = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)  # hears both kinds


class InterleavedSequences:
    """Whether the sequence numbers of a topic's messages are those of several publishers.

    Args:
        now: Steady time at which a second publisher became known in [s].
    """

    def __init__(self, now: float) -> None:
        self._since = now
        self._last: int | None = None
        self._falls: deque[float] = deque(maxlen=FALLS)
        self._unnumbered = self._several = False

    def see(self, number: int | None, now: float) -> None:
        """Take note of a message.

        Args:
            number: Its sequence number; None from a middleware that has none.
            now: Steady time in [s].
        """
        self._unnumbered = number is None
        if number is None:
            return
        if self._last is not None and number <= self._last:
            self._falls.append(now)
            self._several |= len(self._falls) == FALLS and now - self._falls[0] <= WINDOW
        self._last = number

    def holds(self, now: float) -> bool:
        """Whether several send; it is over when one of them has been silent for long.

        Args:
            now: Steady time in [s].
        """
        if self._unnumbered:
            return now - self._since > UNNUMBERED
        return self._several and now - self._falls[-1] <= WINDOW


class DuplicateSenders:
    """Looks once a second whether topics have more than one sender: they would fight.

    A node that was killed stays known until its lease has run out, 20 s in Fast DDS; restarted in
    that time it is no second sender. So it counts who sends, not who is known: while a topic has
    two publishers, its messages are listened to beside the node's own subscription for their
    sequence numbers. Those of one publisher only rise. Where two take turns they fall again and
    again, after a restart once. A middleware that does not number its messages is given
    :data:`UNNUMBERED` instead, after which a dead publisher is known no longer.

    The messages are taken from the middleware by hand: the executor for control loops calls nobody
    with sequence numbers.

    Args:
        node: That looks.
        topics: That have one sender each.
        tell: Called with words when several send, and with none when it is over.
    """

    def __init__(self, node: Node, topics: Sequence[Topic], tell: Callable[[str], None]) -> None:
        self._node, self._tell, self._told = node, tell, ""
        self._topics = [(topic, node.resolve_topic_name(topic.name)) for topic in topics]
        self._heard: dict[str, tuple[InterleavedSequences, NumberedSubscription]] = {}
        steady_timer(node, LOOK_PERIOD, self._look)

    def _look(self) -> None:
        now = time.monotonic()
        words = "; ".join(filter(None, (self._judged(*each, now) for each in self._topics)))
        if words != self._told:
            self._told = words
            self._tell(words)

    def _judged(self, topic: Topic, name: str, now: float) -> str:
        """What is wrong with the senders of a topic, in words; "" if nothing is."""
        if self._node.count_publishers(name) < 2:
            if name in self._heard:
                self._heard.pop(name)[1].close()
            return ""
        if name not in self._heard:
            listened = NumberedSubscription(self._node, topic.type, name, QUEUE)
            self._heard[name] = InterleavedSequences(now), listened
        sequences, listened = self._heard[name]
        for number in listened.numbers():
            sequences.see(number, now)
        if not sequences.holds(now):
            return ""
        senders = sorted(
            f"{each.node_namespace.rstrip('/')}/{each.node_name}"
            for each in self._node.get_publishers_info_by_topic(name)
        )
        return f"{name} has {len(senders)} senders, must have one: {', '.join(senders)}"
