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

"""Whether a topic that has one sender has a second one: two would fight over the aircraft.

A node that was killed stays known until its lease has run out, 20 s in Fast DDS; restarted in that
time it is no second sender. So it counts who sends, not who is known: while a topic has two
publishers, its messages are listened to beside the node's own subscription for their sequence
numbers. Those of one publisher only rise. Where two take turns they fall again and again, after a
restart once. A middleware that does not number its messages is given :data:`UNNUMBERED` instead,
after which a dead publisher is known no longer.

The messages are taken from the middleware by hand: the executor for control loops calls nobody with
sequence numbers.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence

from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.ros.endpoints import steady_timer
from uav_tracking_mpc.nodes.ros.rclpy_internals import NumberedSubscription
from uav_tracking_mpc.nodes.topics import Topic

PERIOD = 1.0  # s between looks
WINDOW = 5.0  # s in which numbers fall often enough where two send
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
        self._unnumbered = False

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
        self._last = number

    def holds(self, now: float) -> bool:
        """Whether several send.

        Args:
            now: Steady time in [s].
        """
        if self._unnumbered:
            return now - self._since > UNNUMBERED
        return len(self._falls) == FALLS and now - self._falls[0] <= WINDOW


class DuplicateSenders:
    """Looks once a second whether topics have more than one sender.

    Args:
        node: That looks.
        topics: That have one sender each.
        tell: Called with words when several send, and with none when it is over.
    """

    def __init__(self, node: Node, topics: Sequence[Topic], tell: Callable[[str], None]) -> None:
        self._node, self._tell, self._told = node, tell, ""
        self._topics = [(topic, node.resolve_topic_name(topic.name)) for topic in topics]
        self._heard: dict[str, tuple[InterleavedSequences, NumberedSubscription]] = {}
        steady_timer(node, PERIOD, self._look)

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
