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

"""Controller, link and simulated autopilot, step by step."""

from __future__ import annotations

import contextlib
import math

from uav_tracking_mpc.autopilot.stepped_autopilot import SteppedAutopilot
from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.launch.preflight import with_envelope
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.engagement import State
from uav_tracking_mpc.links.mavlink.mavlink_link import MavlinkLink
from uav_tracking_mpc.parameters.registry import VEHICLE_LINK
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.target_sensor import TargetSensor
from uav_tracking_mpc.studies.link_faults.sent_messages import SentMessages

CONNECT_LIMIT, WAIT = 20.0, 0.1  # s
# What the simulated one is told as a user would tell a real one: `link check` asks for it.
TOLD = {"px4": {"COM_OBL_RC_ACT": 5.0}}


class LinkFlight:
    """A flight about the target of a configuration.

    Args:
        dialect: Name of the link and of its autopilot.
        configuration: What is flown; the vehicle's limits take the place of its own.

    Attributes:
        autopilot: What flies.
        link: To it.
        controller: Of the flight.
        sent: What was sent, judged.
        command: The newest; None before the first.

    Raises:
        LinkError: The autopilot refuses to be flown.
    """

    def __init__(self, dialect: str, configuration: Configuration) -> None:
        self.autopilot = SteppedAutopilot(dialect, configuration)
        for name, value in TOLD.get(dialect, {}).items():
            self.autopilot.core.parameters.set(name, value)
        self._motion = motion_of(configuration.target)
        self._sensor = TargetSensor(configuration.target, self._motion)
        self._period, self._measured_at = 1.0 / configuration.target.rate, -math.inf
        self.sent = SentMessages(self._limits, self._commanding)
        kind = VEHICLE_LINK.find(dialect)
        self.link: MavlinkLink = kind("", LinkParameters(link=dialect), self._connection)
        self.link.connect(CONNECT_LIMIT)
        found = self.link.inspect()
        if found.refusals:
            raise LinkError("; ".join(found.refusals))
        envelope = {"autopilot_holds": self.link.holds, **found.envelope}
        fitted, _ = with_envelope(configuration, envelope)
        self.parameters = fitted.controller
        self.controller = Controller(self.parameters, stopwatch=lambda: 0.0)
        self.command: Command | None = None

    def _connection(self, address: str, component: int, key: str) -> Connection:
        return self.sent.watched(self.autopilot.connection(address, component, key))

    def _limits(self) -> tuple[float, float, float, float, float]:
        known = self.autopilot.core.parameters
        if "FW_R_LIM" not in known:
            return math.radians(known["ROLL_LIMIT_DEG"]), -math.pi, math.pi, 0.0, 1.0
        pitch = math.radians(known["FW_P_LIM_MIN"]), math.radians(known["FW_P_LIM_MAX"])
        return math.radians(known["FW_R_LIM"]), *pitch, known["FW_THR_MIN"], known["FW_THR_MAX"]

    def _commanding(self) -> bool:
        return self.link.engagement.state is not State.IDLE

    @property
    def time(self) -> float:
        """Simulated, in [s]."""
        return self.autopilot.time

    @property
    def errors(self) -> tuple[float, float]:
        """True errors of range and altitude about the target in [m]."""
        state = self.autopilot.core.state
        x, y, z = self._motion.position(self.time).tolist()
        east, north, up = state.east - x, state.north - y, state.up - z
        orbit = self.parameters.orbit
        distance = math.sqrt(east * east + north * north + up * up)
        return distance - orbit.range, up - orbit.altitude

    def step(self) -> None:
        """Go on by one measurement, or by the time that one may take."""
        measured = self.link.measured(WAIT)
        now = self.link.now()
        if now - self._measured_at >= self._period:
            self._measured_at = now
            self._sensor.measure(now)
        for stamp, position in self._sensor.delivered(now):
            with contextlib.suppress(MeasurementError):  # ahead of stamps of a clock that jumped
                self.controller.see_target(stamp, position)
        self.controller.engage(self.link.engaged)
        if measured is None:
            return
        if self.controller.formulation is not None:  # simulated time waits for a solve
            self.controller.formulation.solver.time_limit = math.inf
        command = self.controller.step(measured, now)
        if command is not None:
            self.command = command
            self.link.command(command.stamp, command.inputs, command.step, command.flown_orbit)

    def silent(self, duration: float) -> None:
        """Let time go on without us: the companion is dead.

        Args:
            duration: In [s].
        """
        end = self.time + duration
        while self.time < end:
            self.autopilot.tick()
