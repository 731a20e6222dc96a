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

"""Faults on the wire to a simulated autopilot, one after the other, and what came of each.

Controller, link and autopilot fly step by step in simulated time; every message that is sent is
judged.
"""

from __future__ import annotations

import contextlib
import math
import random
import time
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from rich.console import Console

from uav_tracking_mpc.autopilot.simulated_autopilot import SteppedAutopilot
from uav_tracking_mpc.autopilot.wire_faults import WIRE_FAULTS
from uav_tracking_mpc.control.controller import Controller
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
from uav_tracking_mpc.studies.faults.fault_campaign import FaultCampaign, Injection
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.schedule import Case
from uav_tracking_mpc.studies.study import Study

SETTLING_LIMIT = 90.0  # s to the orbit, from wherever the autopilot was left
LOITERS = ("LOITER", "RTL", "HOLD", "RETURN", "GUIDED", "OFFBOARD")  # it circles by itself
HAND_FLOWN = ("FBWA", "MANUAL", "RTL", "LOITER", "STABILIZED", "HOLD")
BAD_FRAMES = 100_000  # frames
SHORT_SHARE = 0.7  # -, of the frames that lose a few bytes at most
SENDER = 3  # code: MAVLink system of the good frames
ROUNDING = math.radians(0.02)  # rad, rounding: a bank is a single, a limit in degrees
ROLL_IGNORED_AS_ATTITUDE = 0b10000000  # bits with which ArduPlane takes the axes one by one
FORBIDDEN = {
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: "arms or disarms",
    mavlink.MAV_CMD_NAV_TAKEOFF: "takes off",
    mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: "reboots",
}
CONNECT_LIMIT, WAIT = 20.0, 0.1  # s
# The code that a user sets in a real autopilot, because `link check` asks for it.
TOLD = {"px4": {"COM_OBL_RC_ACT": 5.0}}


class LinkCampaign(FaultCampaign):
    """A campaign over a link, in simulated time, about the target of a configuration.

    Args:
        dialect: Name of the link and of the simulated autopilot.
        configuration: What is flown; the vehicle's limits take the place of its own.
        console: Where progress goes.

    Attributes:
        autopilot: What flies.
        link: To it.
        controller: Of the flight.
        set_points: How many were sent.
        silent: Whether the companion is dead: time goes on without us.

    Raises:
        LinkError: The autopilot refuses to be flown.
    """

    tolerance = 1.0

    def __init__(self, dialect: str, configuration: Configuration, console: Console) -> None:
        super().__init__(configuration, LINK_FAULTS, console)
        self._dialect = dialect
        self.begin_anew()

    def begin_anew(self) -> bool:
        """See :meth:`FaultCampaign.begin_anew`."""
        configuration = self.configuration
        self.autopilot = SteppedAutopilot(self._dialect, configuration)
        for name, value in TOLD.get(self._dialect, {}).items():
            self.autopilot.core.parameters.set(name, value)
        self.set_points, self.silent = 0, False
        self._motion = motion_of(configuration.target)
        self._sensor = TargetSensor(configuration.target, self._motion)
        self._measured_at = -math.inf
        kind = VEHICLE_LINK.find(self._dialect)
        self.link: MavlinkLink = kind("", LinkParameters(link=self._dialect), self._connection)
        self.link.connect(CONNECT_LIMIT)
        found = self.link.inspect()
        if found.refusals:
            raise LinkError("; ".join(found.refusals))
        envelope = {"autopilot_holds": self.link.holds, **found.envelope}
        fitted, _ = with_envelope(configuration, envelope)
        self.controller = Controller(fitted.controller, stopwatch=lambda: 0.0)
        return True

    def now(self) -> float:
        """See :meth:`FaultCampaign.now`: of simulated time."""
        return self.recovery.flown

    def fly(self, cases: Iterable[Case], *, seed: int) -> Study:
        """Fly cases until there are no more, or the user interrupts.

        Args:
            cases: In this order.
            seed: Of the cases, for the record.

        Raises:
            KeyboardInterrupt: Before the first case was flown; later the findings are returned.
        """
        interrupted = self.fly_cases(cases)
        connection = SteppedAutopilot(self._dialect, self.configuration).connection("", 191, "")
        frames = read_bad_frames(connection, BAD_FRAMES, seed)
        return self.study(seed, dialect=self._dialect, interrupted=interrupted, frames=frames)

    def prepare(self) -> None:
        """See :meth:`FaultCampaign.prepare`: hand command over as a pilot does, reach the orbit."""
        begin, asked = self.now(), -math.inf
        self.recovery.begin()
        if not self.link.engaged:
            self.autopilot.pilot_mode(self.autopilot.core.loiter_mode)
        for _ in self.watch():
            if not self.link.engaged and self.now() - asked > 1.0:
                asked = self.now()
                self.link.engage()
            if self.now() - begin > SETTLING_LIMIT:
                raise RuntimeError(f"not on the orbit {SETTLING_LIMIT:g} s after it was engaged")
            if self.recovery.done() is not None:
                return

    def watch(self, injections: Sequence[Injection] = ()) -> Iterator[bool]:
        """See :meth:`FaultCampaign.watch`: simulated time never stands still."""
        while True:
            self.step()
            self.sample()
            yield False

    def excused(self, case: Case) -> bool:
        """See :meth:`FaultCampaign.excused`: the autopilot circles and waits to be engaged."""
        by_itself = self.autopilot.core.mode in LOITERS and not self.link.engaged
        return by_itself or TakeOver.name in case.kinds

    def step(self) -> None:
        """Go on by one measurement, or by the time that one may take."""
        if self.silent:
            self.autopilot.tick()
        else:
            self._control()
        time, state = self.autopilot.time, self.autopilot.core.state
        orbit = self.controller.parameters.orbit
        x, y, z = self._motion.position(time).tolist()
        up = state.up - z
        range_error = math.hypot(state.east - x, state.north - y, up) - orbit.range
        self.recovery.state(time, range_error, up - orbit.altitude, self.link.engaged)

    def _control(self) -> None:
        measured, now = self.link.measured(WAIT), self.link.now()
        if now - self._measured_at >= 1.0 / self.configuration.target.rate:
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
            self.link.command(command.stamp, command.inputs, command.step, command.flown_orbit)

    def _connection(self, address: str, component: int, key: str) -> Connection:
        """The link's end of the wire, with everything that it sends judged."""
        connection = self.autopilot.connection(address, component, key)
        send = connection.send

        def judged(message: Any) -> None:
            self._judge(message)
            send(message)

        connection.send = judged  # type: ignore[method-assign]
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
        if self.link.engagement.state is State.IDLE:
            self.blame("engaged", "a set-point was sent while nobody was engaged")
        bank_max, pitch_min, pitch_max, thrust_min, thrust_max = self._limits()
        w, x, y, z = message.q
        bank = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
        if abs(bank) > bank_max + ROUNDING:
            self.blame("bank", f"{math.degrees(bank):.1f} deg, may {math.degrees(bank_max):.1f}")
        if message.type_mask & ROLL_IGNORED_AS_ATTITUDE:
            return
        if not pitch_min - ROUNDING <= pitch <= pitch_max + ROUNDING:
            self.blame("pitch", f"{math.degrees(pitch):.1f} deg")
        if not thrust_min - 1e-6 <= message.thrust <= thrust_max + 1e-6:
            self.blame("thrust", f"{message.thrust:g}")

    def _limits(self) -> tuple[float, float, float, float, float]:
        """Bank, least and greatest pitch of now, in [rad], and thrust [-]."""
        known = self.autopilot.core.parameters
        if "FW_R_LIM" not in known:
            return math.radians(known["ROLL_LIMIT_DEG"]), -math.pi, math.pi, 0.0, 1.0
        pitch = math.radians(known["FW_P_LIM_MIN"]), math.radians(known["FW_P_LIM_MAX"])
        return math.radians(known["FW_R_LIM"]), *pitch, known["FW_THR_MIN"], known["FW_THR_MAX"]


class WireFault(Fault):
    """A fault of the wire.

    Args:
        name: One of :data:`~uav_tracking_mpc.autopilot.wire_faults.WIRE_FAULTS`.
    """

    family = "wire"

    def __init__(self, name: str) -> None:
        self.name, self.duration = name, WIRE_FAULTS[name].duration

    def begin(self, flight: Any, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        self._fault = flight.autopilot.begin_fault(self.name, seed)

    def end(self, flight: Any) -> None:
        """See :meth:`Fault.end`."""
        flight.autopilot.end_fault(self._fault)


class TakeOver(Fault):
    """The pilot switches to another mode; nothing may be commanded after the message that says so.

    It is watched for as long as it lasts.
    """

    name = "take_over"
    family = "pilot"
    duration = (3.0, 3.0)

    def begin(self, flight: Any, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        self._told: list[int] = []
        self._before = flight.link.heard.on_message

        def listen(message: Any, arrival: float) -> None:
            self._before(message, arrival)
            tells = message.get_type() in ("HEARTBEAT", "CURRENT_MODE")
            if tells and not flight.link.takes_commands(message.custom_mode):
                self._told.append(flight.set_points)

        flight.link.heard.on_message = listen
        modes = [mode for mode in HAND_FLOWN if mode in flight.autopilot.core.modes]
        self._mode = random.Random(seed).choice(modes)
        flight.autopilot.pilot_mode(self._mode)

    def end(self, flight: Any) -> None:
        """See :meth:`Fault.end`."""
        flight.link.heard.on_message = self._before
        late = flight.set_points - (self._told[0] if self._told else 0)
        if late or flight.link.engaged:
            flight.blame("take-over", f"{late} set-points after mode {self._mode} was told")


class CompanionDead(Fault):
    """The companion is dead for a while, then comes back as if nothing had been."""

    name = "companion_dead"
    family = "companion"
    duration = (10.0, 40.0)

    def begin(self, flight: Any, seconds: float, seed: int) -> None:
        """See :meth:`Fault.begin`."""
        flight.silent = True

    def end(self, flight: Any) -> None:
        """See :meth:`Fault.end`."""
        flight.silent = False


LINK_FAULTS: dict[str, Fault] = {
    fault.label: fault for fault in (*map(WireFault, WIRE_FAULTS), TakeOver(), CompanionDead())
}


def changed(random_: random.Random, good: bytes) -> bytes:
    """A frame of which a stretch is lost or other bytes stand in its place; never the same.

    Args:
        random_: Where all that is random comes from.
        good: The frame.
    """
    while True:
        start, end = sorted(random_.choices(range(len(good) + 1), k=2))
        if random_.random() < SHORT_SHARE:
            end = min(end, start + random_.randint(1, 8))
        count = random_.choice((0, end - start, random_.randrange(1, 300)))
        bad = good[:start] + random_.randbytes(count) + good[end:]
        if bad != good:
            return bad


def read_bad_frames(connection: Connection, count: int, seed: int) -> dict[str, float]:
    """Bad frames, each followed by a good one, as a connection reads them.

    Args:
        connection: Of datagrams; nothing is sent.
        count: Of bad frames.
        seed: Of everything random.

    Returns:
        ``bad``: how many; ``taken``: of them for messages, the checksum of 16 bits lets one in
        65 536 pass; ``good_lost``: good ones that were not read; ``bad_us`` and ``good_us``: time
        for one in [us].
    """
    random_, sender = random.Random(seed), mavlink.MAVLink(None, SENDER, 1)
    heartbeat = mavlink.MAVLink_heartbeat_message(1, 3, 128, 15, mavlink.MAV_STATE_ACTIVE, 3)
    taken = lost = 0
    bad_time = good_time = 0.0
    for _ in range(count):
        good = bytes(heartbeat.pack(sender))
        sender.seq = (sender.seq + 1) % 256
        bad = changed(random_, good)
        begin = time.perf_counter()
        passed = connection.parse(bad)
        middle = time.perf_counter()
        read = connection.parse(good)
        good_time += time.perf_counter() - middle
        bad_time += middle - begin
        # A frame with bytes put before or after it is still a good one.
        taken += sum(message.to_dict() != heartbeat.to_dict() for message in passed)
        lost += [message.to_dict() for message in read] != [heartbeat.to_dict()]
    return {
        "bad": count,
        "taken": taken,
        "good_lost": lost,
        "bad_us": 1e6 * bad_time / count,
        "good_us": 1e6 * good_time / count,
    }
