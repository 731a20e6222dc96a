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

"""Whether anybody is at the other end of a topic, as the middleware reports it.

A publisher that ends is gone at once, one that is killed only when its lease has run out, which in
Fast DDS is 20 s: the watchdogs on steady clocks remain what keeps the aircraft safe. No deadline or
liveliness is asked for on subscriptions: a publisher that offers none would not be connected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.qos import LivelinessPolicy, QoSProfile

from uav_tracking_mpc.nodes.topics import Topic

LEASE = 1.0  # s in which a publisher says that it is alive, for those who ask for it
LATE = 2.0  # periods from message to message, beyond which the deadline is missed


@dataclass(frozen=True)
class _Matched:
    """What rclpy says of a match: how many there are now, and what that changed."""

    current_count: int
    current_count_change: int


class Peers:
    """Publishers that a node listens to.

    Args:
        lost: Called with words when the last publisher of a topic is gone.
    """

    def __init__(self, lost: Callable[[str], None]) -> None:
        self._lost = lost
        self._counts: dict[str, int] = {}

    def listening(self, topic: Topic) -> SubscriptionEventCallbacks:
        """Callbacks for the subscription of a topic.

        Args:
            topic: That is listened to.
        """
        self._counts[topic.name] = 0

        def matched(event: _Matched) -> None:
            self._counts[topic.name] = event.current_count
            if event.current_count == 0 and event.current_count_change < 0:
                self._lost(f"nobody publishes {topic.name} any more")

        return SubscriptionEventCallbacks(matched=matched)

    def values(self) -> dict[str, object]:
        """For /diagnostics."""
        return {f"publishers of {name}": count for name, count in self._counts.items()}


class Promise:
    """A rate that a publisher promises, in wall time.

    Args:
        rate: Messages a second in [Hz]; None in simulated time, of which the wall clock says
            nothing.

    Attributes:
        rate: Messages a second that are meant to be sent in [Hz]; a lower one than promised is no
            message too late.
        broken: How often the next message was too late.
    """

    def __init__(self, rate: float | None) -> None:
        self._rate = self.rate = rate
        self.broken = 0

    def qos(self, qos: QoSProfile) -> QoSProfile:
        """The profile of a topic, with deadline and liveliness.

        Args:
            qos: Of the topic.
        """
        deadline = Duration() if self._rate is None else Duration(seconds=LATE / self._rate)
        return QoSProfile(
            depth=qos.depth,
            reliability=qos.reliability,
            liveliness=LivelinessPolicy.AUTOMATIC,
            liveliness_lease_duration=Duration(seconds=LEASE),
            deadline=deadline,
        )

    def callbacks(self, missed: Callable[[], None]) -> PublisherEventCallbacks:
        """Callbacks for the publisher.

        Args:
            missed: Called when the next message is too late.
        """
        if (promised := self._rate) is None:
            return PublisherEventCallbacks()

        def on_missed(event: object) -> None:
            if self.rate is None or self.rate < promised:
                return
            self.broken += 1
            missed()

        return PublisherEventCallbacks(deadline=on_missed)
