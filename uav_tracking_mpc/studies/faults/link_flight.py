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

"""Controller, link and simulated autopilot, step by step; every message that is sent is judged."""

from __future__ import annotations

import contextlib
import math
from collections import Counter
from collections.abc import Callable
from typing import Any

from uav_tracking_mpc.autopilot.stepped_autopilot import SteppedAutopilot
from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.dynamics.frames import bank_from_quaternion
from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.launch.preflight import with_envelope
from uav_tracking_mpc.links import VEHICLE_LINK, LinkError
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.engagement import State
from uav_tracking_mpc.links.mavlink.mavlink_link import MavlinkLink
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.motions import motion_of
from uav_tracking_mpc.simulation.steered_target import TargetSensor

ROUNDING = math.radians(0.02)  # rad, rounding: a bank is a single, a limit in degrees
ROLL_IGNORED_AS_ATTITUDE = 0b10000000  # bits with which ArduPlane takes the axes one by one
FORBIDDEN = {
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: "arms or disarms",
    mavlink.MAV_CMD_NAV_TAKEOFF: "takes off",
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: "reboots",
}


class SentMessages:
    """Judges what goes out on a connection.

    Args:
        limits: Gives the autopilot's limits of now: bank, least and greatest pitch, in [rad], and
            thrust [-].
        commanding: Whether set-points may be sent now.

    Attributes:
        set_points: How many set-points were sent.
        broken: Of each rule how often it was broken, and how for the first time.
    """

    def __init__(
        self,
        limits: Callable[[], tuple[float, float, float, float, float]],
        commanding: Callable[[], bool],
    ) -> None:
        self._limits, self._commanding = limits, commanding
        self.set_points = 0
        self.broken: dict[str, str] = {}
        self._counts: Counter[str] = Counter()

    def take(self) -> dict[str, tuple[int, str]]:
        """What was broken since the last call: count and words by rule."""
        found = {name: (self._counts[name], words) for name, words in self.broken.items()}
        self.broken, self._counts = {}, Counter()
        return found

    def blame(self, rule: str, words: str) -> None:
        """Note that a rule was broken.

        Args:
            rule: Its name.
            words: How.
        """
        self._counts[rule] += 1
        self.broken.setdefault(rule, words)

    def watched(self, connection: Connection) -> Connection:
        """The connection, with everything that it sends looked at.

        Args:
            connection: Of the link.
        """
        send = connection.send

        def looked_at(message: Any) -> None:
            self._judge(message)
            send(message)

        connection.send = looked_at  # type: ignore[method-assign]
        return connection

    def _judge(self, message: Any) -> None:
        kind = message.get_type()
        numbers = [value for value in message.to_dict().values() if isinstance(value, float)]
        numbers += [float(value) for value in getattr(message, "q", ())]
        if not all(map(math.isfinite, numbers)):
            self.blame("finite", f"{kind} holds {message}")
        if kind == "SET_ATTITUDE_TARGET":
            self._judge_set_point(message)
        elif kind in ("PARAM_SET", "SET_MODE"):
            self.blame("harmless", f"{kind} was sent")
        elif kind in ("COMMAND_LONG", "COMMAND_INT") and message.command in FORBIDDEN:
            self.blame("harmless", f"a command that {FORBIDDEN[message.command]} was sent")

    def _judge_set_point(self, message: Any) -> None:
        self.set_points += 1
        if not self._commanding():
            self.blame("engaged", "a set-point was sent while nobody was engaged")
        bank_max, pitch_min, pitch_max, thrust_min, thrust_max = self._limits()
        w, x, y, z = message.q
        bank = bank_from_quaternion(x, y, z, w)
        pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
        if abs(bank) > bank_max + ROUNDING:
            self.blame("bank", f"{math.degrees(bank):.1f} deg, may {math.degrees(bank_max):.1f}")
        if message.type_mask & ROLL_IGNORED_AS_ATTITUDE:
            return
        if not pitch_min - ROUNDING <= pitch <= pitch_max + ROUNDING:
            self.blame("pitch", f"{math.degrees(pitch):.1f} deg")
        if not thrust_min - 1e-6 <= message.thrust <= thrust_max + 1e-6:
            self.blame("thrust", f"{message.thrust:g}")


CONNECT_LIMIT, WAIT = 20.0, 0.1  # s
# The code that a user sets in a real autopilot, because `link check` asks for it.
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
        silent: Whether the companion is dead: time goes on without us.

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
        self.silent = False

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
        return self.parameters.orbit.errors_at(state.east - x, state.north - y, state.up - z)

    @property
    def speed(self) -> float:
        """Faults last as long as they say: all of it is simulated time."""
        return 1.0

    def now(self) -> float:
        """Time by which faults begin and end in [s]."""
        return self.time

    def step(self) -> None:
        """Go on by one measurement, or by the time that one may take."""
        if self.silent:
            self.autopilot.tick()
            return
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
