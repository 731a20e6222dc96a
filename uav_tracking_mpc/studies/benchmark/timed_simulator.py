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

"""The simulator's node, which notes when its states are answered, and sends the echo."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.command_wire import command_stamp
from uav_tracking_mpc.nodes.conversions import nanoseconds
from uav_tracking_mpc.nodes.run import run
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.studies.benchmark.echo import EchoCall, RoundTrips

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
        publish = self._odometry_publisher.publish

        def noted(message: Any) -> None:
            self.trips.send(nanoseconds(message.header.stamp))
            publish(message)

        self._odometry_publisher.publish = noted  # type: ignore[method-assign]

    def _publish(self, seen: Measurement) -> None:
        super()._publish(seen)
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


if __name__ == "__main__":
    sys.exit(run("uav_simulator", TimedSimulator))
