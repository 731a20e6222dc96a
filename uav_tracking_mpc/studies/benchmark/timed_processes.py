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

"""Processes of a timed flight: controller and simulator, with an echo of their messages; a page.

Round trips are timed in the simulator's process, beside those of an echo of the same messages. The
page shows the flight to a client that reads it and renders nothing.
"""

from __future__ import annotations

import json
import signal
import sys
import threading
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
from uav_tracking_mpc.report.atomic_write import write_atomically

ECHO_ODOMETRY, ECHO_AIR_VELOCITY, ECHO_COMMAND = (
    replace(topic, name=f"echo/{topic.name}") for topic in (ODOMETRY, AIR_VELOCITY, COMMAND)
)


def timed_controller() -> Node:
    """The controller, which also answers the echo's states: with one and the same plan."""
    from uav_tracking_mpc.nodes.nmpc_controller import NmpcController

    node, wire = NmpcController(), CommandWire()
    segments, step = node.parameters.horizon, node.parameters.horizon_step
    plan = np.zeros((segments, 3))
    path = PlannedPath(np.zeros((segments + 1, 6)), np.zeros((segments + 1, 3)))
    commands = publish(node, ECHO_COMMAND)

    def answer(message: Any) -> None:
        commands.publish(wire.write(nanoseconds(message.header.stamp), plan, step, path))

    listen(node, ECHO_ODOMETRY, answer)
    listen(node, ECHO_AIR_VELOCITY, lambda message: None)
    return node


class RoundTrips:
    """Times from a state's publication to the arrival of the command that answers it.

    Attributes:
        times: When each began, by ``time.perf_counter``, and how long it took, in [s].
    """

    def __init__(self) -> None:
        self.times: list[tuple[float, float]] = []
        self._sent = (0, 0.0)

    def send(self, stamp: int) -> None:
        """Note that a state with this stamp in [ns] is about to be published."""
        self._sent = stamp, time.perf_counter()

    def arrive(self, stamp: int) -> None:
        """Note that a command has come; one that answers an older state does not count."""
        sent, begin = self._sent
        if stamp == sent:
            self.times.append((begin, time.perf_counter() - begin))


WARM_UP = 10.0  # s of flight that do not count; the file is there afterwards


class TimedSimulator(UavSimulator):
    """Writes the round trips of its states and of the echo to a file when it ends.

    The echo's states are sent half a period after the simulator's own.

    Args:
        result: The file.
    """

    def __init__(self, result: str) -> None:
        self.trips, self.echo = RoundTrips(), RoundTrips()
        super().__init__()
        self._result = Path(result)
        self._flown_from: int | None = None  # stamp of the first command [ns]
        self._echoes = publish(self, ECHO_ODOMETRY), publish(self, ECHO_AIR_VELOCITY)
        listen(self, ECHO_COMMAND, lambda data: self.echo.arrive(command_stamp(data)), raw=True)
        self._echo_timer = self.create_timer(0.5 / self.parameters.state_rate, self._send_echo)
        self._echo_timer.cancel()
        publish_state = self._state_publisher.publisher.publish

        def noted(message: Any) -> None:
            self.trips.send(nanoseconds(message.header.stamp))
            publish_state(message)

        self._state_publisher.publisher.publish = noted  # type: ignore[method-assign]

    def _publish(self, stamp: int, seen: Measurement, state: bool = True) -> None:
        super()._publish(stamp, seen, state)
        self._echo_timer.reset()

    def _send_echo(self) -> None:
        self._echo_timer.cancel()
        stamp = self.get_clock().now().nanoseconds
        self.echo.send(stamp)
        for publisher, message in zip(
            self._echoes, (self._odometry, self._air_velocity), strict=True
        ):
            set_stamp(message.header.stamp, stamp)
            publisher.publish(message)

    def _on_command(self, data: bytes) -> None:
        stamp = command_stamp(data)
        self.trips.arrive(stamp)
        super()._on_command(data)
        if self._flown_from is None:
            self._flown_from = stamp
        elif stamp - self._flown_from > WARM_UP * 1e9 and not self._result.exists():
            self._result.touch()
            self.trips.times.clear()
            self.echo.times.clear()

    def finish(self) -> None:
        """Write the times in [s]."""
        super().finish()
        times = {"controller": self.trips.times, "echo": self.echo.times}
        self._result.write_text(json.dumps(times), encoding="utf-8")


COUNT_PERIOD = 0.2  # s between writes of the count


def page(address: str) -> None:
    """Serve a page until SIGTERM.

    Args:
        address: File that the page's address is written to.
    """
    from uav_tracking_mpc.view.live_source import LiveSource
    from uav_tracking_mpc.view.page import Page

    ended = threading.Event()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    shown = Page(LiveSource())
    write_atomically(Path(address), shown.address.encode())
    try:
        shown.serve(ended.is_set)
    finally:
        shown.close()


def page_reader(address: str, counted: str) -> None:
    """Read a page until SIGTERM.

    Args:
        address: File that holds the page's address.
        counted: File that the number of messages is written to.
    """
    import viser
    from websockets.sync.client import connect
    from websockets.typing import Subprotocol

    place = Path(address).read_text(encoding="utf-8").replace("http", "ws", 1)
    count, due = 0, 0.0
    # viser takes clients of its own version alone.
    spoken = [Subprotocol(f"viser-v{viser.__version__}")]
    with connect(place, subprotocols=spoken, max_size=None, compression=None) as connection:
        for _ in connection:
            count += 1
            if (now := time.monotonic()) >= due:
                due = now + COUNT_PERIOD
                write_atomically(Path(counted), str(count).encode())


if __name__ == "__main__":
    name, *given = sys.argv[1:]
    if name == "page":
        page(*given)
    elif name == "page_reader":
        page_reader(*given)
    elif name == "nmpc_controller":
        sys.exit(run(name, timed_controller, given))
    else:
        result, *given = given
        sys.exit(run(name, lambda: TimedSimulator(result), given))
