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

"""An echo between the processes of a flight: what messages cost, whoever answers them.

The simulator's process sends, between two states, the same messages on topics of their own; the
controller's process answers at once with a command of the same size, by nothing but its stamp.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
from rclpy.node import Node

from uav_tracking_mpc.control.planned_path import PlannedPath
from uav_tracking_mpc.nodes.command_wire import CommandWire, command_stamp
from uav_tracking_mpc.nodes.conversions import nanoseconds, set_stamp
from uav_tracking_mpc.nodes.endpoints import listen, publish
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY

ECHO_ODOMETRY, ECHO_AIR_VELOCITY, ECHO_COMMAND = (
    replace(topic, name=f"echo/{topic.name}") for topic in (ODOMETRY, AIR_VELOCITY, COMMAND)
)


class EchoAnswer:
    """Answers the echo's states with one and the same plan.

    Args:
        node: In whose process it answers.
        segments: Of the plan, as many as the controller's have.
        step: Length of a segment in [s].
    """

    def __init__(self, node: Node, segments: int, step: float) -> None:
        self._wire, self._plan, self._step = CommandWire(), np.zeros((segments, 3)), step
        self._path = PlannedPath(np.zeros((segments + 1, 6)), np.zeros((segments + 1, 3)))
        self._commands = publish(node, ECHO_COMMAND)
        listen(node, ECHO_ODOMETRY, self._answer)
        listen(node, ECHO_AIR_VELOCITY, lambda message: None)

    def _answer(self, message: Any) -> None:
        stamp = nanoseconds(message.header.stamp)
        self._commands.publish(self._wire.write(stamp, self._plan, self._step, self._path))


class RoundTrips:
    """Times from a state's publication to the arrival of the command that answers it.

    Attributes:
        times: In [s], as they came.
        began: When each began, by ``time.perf_counter`` in [s].
    """

    def __init__(self) -> None:
        self.times: list[float] = []
        self.began: list[float] = []
        self._sent = (0, 0.0)

    def send(self, stamp: int) -> None:
        """Note that a state is about to be published.

        Args:
            stamp: Of the state in [ns].
        """
        self._sent = stamp, time.perf_counter()

    def arrive(self, stamp: int) -> None:
        """Note that a command has come; one that answers an older state does not count.

        Args:
            stamp: Of the command in [ns].
        """
        sent, begin = self._sent
        if stamp == sent:
            self.times.append(time.perf_counter() - begin)
            self.began.append(begin)

    def clear(self) -> None:
        """Forget those that came so far."""
        self.times.clear()
        self.began.clear()


class EchoCall:
    """Sends the echo's states, half a period after the simulator's own.

    Args:
        node: In whose process it sends.
        delay: From the simulator's state to the echo's in [s].

    Attributes:
        trips: Of the echo.
    """

    def __init__(self, node: Node, delay: float) -> None:
        self._node, self.trips = node, RoundTrips()
        self._states = publish(node, ECHO_ODOMETRY), publish(node, ECHO_AIR_VELOCITY)
        self._messages: tuple[Any, Any] | None = None
        listen(node, ECHO_COMMAND, lambda data: self.trips.arrive(command_stamp(data)), raw=True)
        self._timer = node.create_timer(delay, self._send)
        self._timer.cancel()

    def after(self, odometry: Any, air_velocity: Any) -> None:
        """Send the echo of a state a little later.

        Args:
            odometry: Message of the state.
            air_velocity: Message of the air velocity.
        """
        self._messages = odometry, air_velocity
        self._timer.reset()

    def _send(self) -> None:
        self._timer.cancel()
        if self._messages is None:
            return
        stamp = self._node.get_clock().now().nanoseconds
        for message in self._messages:
            set_stamp(message.header.stamp, stamp)
        self.trips.send(stamp)
        for publisher, message in zip(self._states, self._messages, strict=True):
            publisher.publish(message)
