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

"""Node ``monitor``: a live table of the flight, for terminals without ``ros2 topic``."""

from __future__ import annotations

import functools
import math
import sys
import time
from collections import defaultdict, deque
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rich.console import Console, Group
from rich.live import Live
from rich.markup import escape
from rich.table import Table

from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    plan_from_command,
    position_from_point,
    target_from_odometry,
)
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription, namespaces, steady_timer
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ANY_FRAMES,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
    MessageError,
    Topic,
)

SHOWN = (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY, COMMAND, *TRACKING.values())
QUEUE = 10  # messages that may wait
REFRESH_PERIOD = 0.25  # s
STALE = 2.0  # s of wall time after which a topic counts as silent
GONE = 5.0  # s of wall time after which a node counts as silent that reports once a second
LEVELS = {b"\x00": "ok", b"\x01": "[yellow]warning[/]", b"\x02": "[red]error[/]", b"\x03": "stale"}


class Monitor(Node):
    """Shows what comes on the topics, how often, and what the nodes say of themselves.

    Args:
        console: Where to show it; the terminal by default.
        options: Of rclpy's Node.
    """

    def __init__(self, console: Console | None = None, **options: Any) -> None:
        super().__init__("monitor", **options)
        self._latest: dict[str, Any] = {}
        self._arrivals: dict[str, deque[float]] = defaultdict(lambda: deque(maxlen=20))
        self._statuses: dict[str, tuple[Any, float]] = {}  # and when it came, steady [s]
        self._others: list[str] = []  # namespaces of other aircraft
        for topic in (*SHOWN, DIAGNOSTICS):
            FollowingSubscription(self, topic, functools.partial(self._on_message, topic), QUEUE)
        self._live = Live(self.table(), console=console, refresh_per_second=4)
        self._live.start()
        steady_timer(self, REFRESH_PERIOD, self._refresh)

    def _refresh(self) -> None:
        self._others = sorted(namespaces(self) - {self.get_namespace()})
        self._live.update(self.table())

    def _on_message(self, topic: Topic, message: Any) -> None:
        if topic is DIAGNOSTICS:
            now = time.monotonic()
            self._statuses.update({status.name: (status, now) for status in message.status})
            return
        self._latest[topic.name] = message
        self._arrivals[topic.name].append(time.monotonic())

    def table(self) -> Group:
        """What is known now, as tables."""
        namespace = self.get_namespace()
        title = "flight" if namespace == "/" else f"flight of {namespace}"
        flight = Table(
            "topic", "rate", "value", title=title, caption=self._elsewhere(), expand=True
        )
        for topic in SHOWN:
            flight.add_row(topic.name, self._rate(topic), escape(self._words(topic)))
        nodes = Table("node", "aircraft", "level", "says", title="nodes", expand=True)
        for name, (status, came) in sorted(self._statuses.items()):
            if any(name.startswith(f"{other[1:]}/") for other in self._others if other != "/"):
                continue
            silent = time.monotonic() - came > GONE
            level = "[red]silent[/]" if silent else LEVELS.get(status.level, "?")
            # Others publish here too: their words are text, not markup.
            node, aircraft = escape(name.partition(":")[0]), escape(status.hardware_id)
            nodes.add_row(node, aircraft, level, escape(status.message))
        return Group(flight, nodes)

    def _elsewhere(self) -> str | None:
        """Which other aircraft could be watched."""
        if not self._others:
            return None
        words = f"other aircraft in this domain: {', '.join(self._others)}"
        return f"{words}; watch one with `uav_tracking monitor --namespace {self._others[0]}`"

    def _rate(self, topic: Topic) -> str:
        if not (arrivals := self._arrivals[topic.name]):
            return "nothing yet"
        if time.monotonic() - arrivals[-1] > STALE:
            return "[red]silent[/]"
        span = arrivals[-1] - arrivals[0]
        return f"{(len(arrivals) - 1) / span:.1f} Hz" if span > 0.0 else ""

    def _words(self, topic: Topic) -> str:
        message = self._latest.get(topic.name)
        try:
            return "" if message is None else WORDS.get(topic.name, _figure)(topic, message)
        except MessageError as error:
            return f"unusable: {error}"

    def finish(self) -> None:
        """Leave the last table on the screen."""
        self._live.update(self.table())
        self._live.stop()


def _state(_: Topic, message: Any) -> str:
    motion = measurement_from_odometry(message, frames=ANY_FRAMES)
    return (
        f"{_place(motion.position)}   heading {math.degrees(motion.heading):.1f}  "
        f"path angle {math.degrees(motion.path_angle):.1f} deg   "
        f"ground speed {math.hypot(*motion.ground_velocity):.2f} m/s"
    )


def _target(_: Topic, message: Any) -> str:
    seen = target_from_odometry(message, ANY_FRAMES)
    speed = "" if seen.velocity is None else f"   speed {math.hypot(*seen.velocity):.2f} m/s"
    return f"{_place(seen.position)}{speed}"


def _command(_: Topic, message: Any) -> str:
    yaw, pitch, acceleration = plan_from_command(message, ANY_FRAMES)[0][0]
    return (
        f"yaw rate {yaw:+.4f}  path-angle rate {pitch:+.4f} rad/s   "
        f"acceleration {acceleration:+.4f} m/s^2"
    )


def _place(position: NDArray[np.float64]) -> str:
    x, y, z = position
    return f"x {x:.2f}  y {y:.2f}  z {z:.2f} m"


def _figure(topic: Topic, message: Any) -> str:
    unit = topic.meaning.partition("[")[2].partition("]")[0]
    signed = unit in ("m", "rad", "m/s")
    return f"{message.data:+.4f} {unit}" if signed else f"{message.data:.3g} {unit}"


# What a message says, by the name of its topic; those that are missing hold one figure.
WORDS: dict[str, Callable[[Topic, Any], str]] = {
    ODOMETRY.name: _state,
    AIR_VELOCITY.name: lambda _, message: (
        f"airspeed {math.hypot(*air_velocity_from_twist(message, ANY_FRAMES)):.2f} m/s"
    ),
    TARGET.name: lambda _, message: _place(position_from_point(message, ANY_FRAMES)),
    TARGET_ODOMETRY.name: _target,
    COMMAND.name: _command,
}


if __name__ == "__main__":
    sys.exit(run("monitor", Monitor))
