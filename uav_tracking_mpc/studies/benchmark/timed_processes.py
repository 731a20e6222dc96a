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

"""Controller and simulator with round trips timed, beside an echo of the same messages."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.node import Node

from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, set_stamp
from uav_tracking_mpc.nodes.messages.wires import CommandWire, command_stamp
from uav_tracking_mpc.nodes.ros.endpoints import listen, publish
from uav_tracking_mpc.nodes.ros.process import run
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator

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


RESULT = "round_trips"  # parameter: file that the times are written to
WARM_UP = 10.0  # s of flight that do not count; the file is there afterwards


class TimedSimulator(UavSimulator):
    """Writes the round trips of its states and of the echo to a file when it ends.

    Args:
        options: As those of rclpy's Node.
    """

    def __init__(self, **options: Any) -> None:
        self.trips = RoundTrips()
        super().__init__(**options)
        self._echo = EchoCall(self, 0.5 / self.parameters.state_rate)
        self._result = Path(self.declare_parameter(RESULT, "").value)
        self._flown_from: int | None = None  # stamp of the first command [ns]
        publish = self._state_publisher.publisher.publish

        def noted(message: Any) -> None:
            self.trips.send(nanoseconds(message.header.stamp))
            publish(message)

        self._state_publisher.publisher.publish = noted  # type: ignore[method-assign]

    def _publish(self, stamp: int, seen: Measurement, state: bool = True) -> None:
        super()._publish(stamp, seen, state)
        self._echo.after(self._odometry, self._air_velocity)

    def _on_command(self, data: bytes) -> None:
        stamp = command_stamp(data)
        self.trips.arrive(stamp)
        super()._on_command(data)
        if self._flown_from is None:
            self._flown_from = stamp
        elif stamp - self._flown_from > WARM_UP * 1e9 and not self._result.exists():
            self._result.touch()
            for trips in (self.trips, self._echo.trips):
                trips.clear()

    def finish(self) -> None:
        """Write the times in [s]."""
        super().finish()
        times = {
            "controller": self.trips.times,
            "controller_began": self.trips.began,
            "echo": self._echo.trips.times,
        }
        self._result.write_text(json.dumps(times), encoding="utf-8")


def _timed_controller() -> Node:
    from uav_tracking_mpc.nodes.nmpc_controller import NmpcController

    node = NmpcController()
    EchoAnswer(node, node.parameters.horizon, node.parameters.horizon_step)
    return node


if __name__ == "__main__":
    NODES = {"nmpc_controller": _timed_controller, "uav_simulator": TimedSimulator}
    sys.exit(run(sys.argv[1], NODES[sys.argv[1]], sys.argv[2:]))
