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

"""Everything that is heard of one autopilot, and what keeps it talking.

A vehicle to circle may tell where it is on the same wire: GLOBAL_POSITION_INT or FOLLOW_TARGET.
"""

from __future__ import annotations

import contextlib
import math
from collections import Counter, deque
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.estimation.flight_path import LEAST_AIRSPEED
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import LinkError, LinkRefusedError, Sighting
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink, name_of
from uav_tracking_mpc.links.mavlink.requests import Requests, long_command
from uav_tracking_mpc.links.mavlink.telemetry import DEGREE_SCALE, AutopilotClock, Telemetry
from uav_tracking_mpc.settings.link import LinkParameters

HAS_VELOCITY = 0b10  # bit of FOLLOW_TARGET's est_capabilities


class VehicleSighting:
    """Follows one MAVLink system.

    Its clock is not ours; the least delay of its messages aligns the two.
    """

    def __init__(self) -> None:
        self._clock = AutopilotClock()
        self._newest: Sighting | None = None

    def take(self) -> Sighting | None:
        """The newest sighting that nobody has taken yet."""
        newest, self._newest = self._newest, None
        return newest

    def see(self, message: Any, arrival: float, frame: LocalFrame) -> None:
        """Take in a message.

        Args:
            message: Of that system.
            arrival: Our time in [s].
            frame: Axes of ``map``.
        """
        kind = message.get_type()
        if kind == "GLOBAL_POSITION_INT":
            time, altitude = message.time_boot_ms * 1e-3, message.alt * 1e-3
            velocity = [message.vy * 1e-2, message.vx * 1e-2, -message.vz * 1e-2]
        elif kind == "FOLLOW_TARGET":
            time, altitude = message.timestamp * 1e-3, message.alt
            north, east, down = message.vel
            velocity = [east, north, -down] if message.est_capabilities & HAS_VELOCITY else []
        else:
            return
        nowhere = not math.isfinite(altitude + sum(velocity)) or message.lat == message.lon == 0
        if nowhere or not self._clock.see_stamp(time, arrival):
            return
        position = frame.position(message.lat * DEGREE_SCALE, message.lon * DEGREE_SCALE, altitude)
        stamp = min(self._clock.ours(time), arrival)
        self._newest = Sighting(stamp, position, np.array(velocity) if velocity else None)


FIXED_WING = {
    mavlink.MAV_TYPE_FIXED_WING,
    *(value for value, entry in mavlink.enums["MAV_TYPE"].items() if "VTOL" in entry.name),
}
ALWAYS = (
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
    mavlink.MAVLINK_MSG_ID_ATTITUDE,
    mavlink.MAVLINK_MSG_ID_VFR_HUD,
)
COUNTED = tuple(mavlink.mavlink_map[number].msgname for number in ALWAYS)
NOW_AND_THEN = (
    mavlink.MAVLINK_MSG_ID_SYS_STATUS,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
)
HEARTBEAT_PERIOD, SYNC_PERIOD, ASKING_PERIOD = 1.0, 0.5, 1.0  # s
SLOW_RATE, QUICK_RATE = 2.0, 10.0  # Hz
REOPEN_PERIOD = 1.0  # s between attempts to open a lost wire
KEPT_RATE = 0.7  # -, of the messages that came at best, below which they are asked for again
LOST = 5.0  # s without a heartbeat
STALL = 2.0  # s in which nobody read, after which what waits is too old for its arrival to count
BACKLOG = 10000  # reads in a row of what waits
STAMPS_WRAP = 2**32 * 10**6  # ns, at which time_boot_ms begins at 0 again: 49.7 days
HISTORY = 1.0  # s of age from which on a measurement is none: it waited while we were stopped
SEVERE = 4  # code MAV_SEVERITY up to which the autopilot's words are warnings


class Listener:
    """One end of a connection to one autopilot.

    Args:
        connection: To where it is.
        parameters: Of the link.
        events: Where what happens is reported.
        slow_messages: Asked for now and then, beside those of every autopilot.
        quick_messages: Asked for often, so that what they tell is not missed.

    Attributes:
        connection: The wire.
        requests: Commands under way.
        clock: Of the autopilot.
        telemetry: What it told of its flight.
        target: The vehicle to circle.
        heartbeat: Its newest HEARTBEAT; None before the first.
        latest: Its newest message of each kind, by name.
        measurements: Not taken yet.
        on_message: Called with each of its messages and our time in [s].
        on_measurement: Called with each measurement and our time in [s].
        on_restart: Called when it has booted anew.
    """

    def __init__(
        self,
        connection: Connection,
        parameters: LinkParameters,
        events: EventLog,
        slow_messages: Iterable[int] = (),
        quick_messages: Iterable[int] = (),
    ) -> None:
        self._parameters, self._events = parameters, events
        self.connection = connection
        self.requests = Requests(connection, events)
        self.clock = AutopilotClock()
        origin = None
        if parameters.origin:
            latitude, longitude, altitude = parameters.origin
            origin = LocalFrame(math.radians(latitude), math.radians(longitude), altitude)
        self.telemetry = Telemetry(self.clock, origin)
        self.target = VehicleSighting()
        self.heartbeat: Any = None
        self.latest: dict[str, Any] = {}
        self.measurements: deque[Measurement] = deque(maxlen=4)
        nothing: Callable[..., None] = lambda *_: None  # noqa: E731
        self.on_message: Callable[[Any, float], None] = nothing
        self.on_measurement: Callable[[Measurement, float], None] = nothing
        self.on_restart: Callable[[], None] = nothing
        self._rates = {
            **dict.fromkeys(ALWAYS, parameters.telemetry_rate),
            **dict.fromkeys((*NOW_AND_THEN, *slow_messages), SLOW_RATE),
            **dict.fromkeys(quick_messages, QUICK_RATE),
        }
        self._asked_at, self._told_lost, self._told_wire = 0, False, False
        self._fixed: bool | None = None  # None before the first fix
        self._heartbeat_at = -math.inf
        self._looked_at = math.inf
        self._counted, self._counted_at = Counter[str](), -math.inf
        self._usual_rates = dict.fromkeys(COUNTED, 0.0)
        self._due: dict[str, float] = {}

    @property
    def telemetry_rate(self) -> float:
        """Of the states that are asked for in [Hz]."""
        return self._parameters.telemetry_rate

    @property
    def system(self) -> int:
        """MAVLink system of the autopilot; 0 before it was found."""
        return self.requests.system

    @property
    def identity(self) -> str:
        """Which autopilot it is: the serial number of its processor, or its number on MAVLink."""
        version = self.latest.get("AUTOPILOT_VERSION")
        if version is not None and any(version.uid2):
            return bytes(version.uid2).hex()
        if version is not None and version.uid:
            return f"{version.uid:016x}"
        return f"MAVLink system {self.system}"

    @property
    def armed(self) -> bool:
        """Whether its motor may run."""
        return bool(self.heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)

    @property
    def in_air(self) -> bool:
        """Whether it says so or, if it says nothing of it, flies by its airspeed."""
        told = self.latest.get("EXTENDED_SYS_STATE")
        if told is not None and told.landed_state:
            return bool(told.landed_state != mavlink.MAV_LANDED_STATE_ON_GROUND)
        return (self.telemetry.airspeed or 0.0) >= LEAST_AIRSPEED

    def find(self, autopilot: int, timeout: float) -> None:
        """Wait for an autopilot, and ask it for telemetry.

        Args:
            autopilot: Of MAV_AUTOPILOT, that it must be.
            timeout: How long in [s].

        Raises:
            LinkError: There is none.
            LinkRefusedError: There is one of another kind, or of another vehicle.
        """
        end = self.connection.now() + timeout
        others: set[str] = set()
        while self.heartbeat is None:
            if self.connection.now() > end:
                words = f"no autopilot answers at {self.connection.address!r} within {timeout:g} s"
                if others:
                    words += f"; heard there: {', '.join(sorted(others))}"
                if self.connection.bad:
                    words += f"; {self.connection.bad} frames were garbled or wrongly signed"
                raise LinkError(words)
            self.tend(self.connection.now())
            for message in self.connection.receive(0.1):
                if message.get_type() != "HEARTBEAT":
                    continue
                system = message.get_srcSystem()
                wanted = self._parameters.system in (0, system)
                wanted = wanted and system != self._parameters.target_system
                if wanted and message.autopilot != mavlink.MAV_AUTOPILOT_INVALID:
                    self._accept(message, system, autopilot)
                else:
                    others.add(f"system {system}, {name_of('MAV_TYPE', message.type)}")
        self.ask_for_telemetry()

    def _accept(self, message: Any, system: int, autopilot: int) -> None:
        where = f"system {system} at {self.connection.address!r}"
        if message.autopilot != autopilot:
            raise LinkRefusedError(
                f"{where} is {name_of('MAV_AUTOPILOT', message.autopilot)}, must be "
                f"{name_of('MAV_AUTOPILOT', autopilot)}"
            )
        if message.type not in FIXED_WING:
            kind = name_of("MAV_TYPE", message.type)
            raise LinkRefusedError(f"{where} is a {kind}, must be a fixed wing")
        self.requests.system = self.connection.watched = system
        self.connection.speak_as(system)
        self.heartbeat, self._heartbeat_at = message, self.connection.now()

    def ask_for_telemetry(self) -> None:
        """Ask for all messages; an autopilot that has restarted has forgotten them.

        Nobody waits for the acknowledgements: the telemetry itself is one.
        """
        interval = mavlink.MAV_CMD_SET_MESSAGE_INTERVAL
        asked = [(interval, message, 1e6 / rate) for message, rate in self._rates.items()]
        version = mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION
        for command in (*asked, version):
            self.connection.send(long_command(self.system, *command))

    def receive(self, timeout: float) -> list[Any]:
        """Take in what has come; nothing comes over a lost wire, see :meth:`restore`.

        Args:
            timeout: How long to wait in [s].

        Returns:
            The autopilot's messages.

        Raises:
            LinkError: The connection is closed.
        """
        stalled = self.connection.now() - self._looked_at > STALL
        try:
            messages = self.connection.receive(timeout)
            if stalled:
                messages = self._modes_of(messages)
        except LinkError as error:
            if self.connection.closed:
                raise
            if not self._told_wire:
                self._told_wire = True
                self._events.add(Level.WARNING, str(error))
            return []
        self._looked_at = self.connection.now()
        arrival, own = self.connection.now(), []
        for message in messages:
            system, component = message.get_srcSystem(), message.get_srcComponent()
            if system == self.system and component == 1:
                own.append(message)
                self._see(message, arrival)
            elif system == self._parameters.target_system and self.telemetry.frame is not None:
                self.target.see(message, arrival, self.telemetry.frame)
        return own

    def _modes_of(self, messages: list[Any]) -> list[Any]:
        """Of all that waits the heartbeats alone: who flew meanwhile counts at any age."""
        for _ in range(BACKLOG):
            if not self.connection.wait(0.0):
                break
            messages = messages + self.connection.receive(0.0)
        return [message for message in messages if message.get_type() == "HEARTBEAT"]

    def restore(self) -> None:
        """Open the wire anew if it was lost; may take its time, so nobody is to wait for it."""
        if self.connection.lost_wire and self.is_due("wire", self.connection.now(), REOPEN_PERIOD):
            with contextlib.suppress(LinkError):  # it is tried again
                self.connection.open()
                self._told_wire = False

    def _see(self, message: Any, arrival: float) -> None:
        """Take in a message of the autopilot."""
        kind = message.get_type()
        self.latest[kind] = message
        self._counted[kind] += 1
        of_this_boot = True
        if hasattr(message, "time_boot_ms"):
            restarts = self.clock.restarts
            of_this_boot = self.clock.see_stamp(message.time_boot_ms * 1e-3, arrival)
            if self.clock.restarts != restarts:
                self._restarted()
        if kind == "HEARTBEAT":
            self._see_heartbeat(message, arrival)
        elif kind == "TIMESYNC":
            if message.tc1 > 0 and message.ts1 == self._asked_at:
                answered = message.tc1 % STAMPS_WRAP  # so do the stamps of all other messages
                self.clock.see_answer(message.ts1 * 1e-9, answered * 1e-9, arrival)
        elif kind == "COMMAND_ACK":
            if self.connection.is_ours(message):
                self.requests.see(message, arrival)
        elif kind == "STATUSTEXT":
            level = Level.WARNING if message.severity <= SEVERE else Level.INFO
            self._events.add(level, f"autopilot: {message.text}")
        elif of_this_boot:
            if kind == "GPS_RAW_INT":
                self._see_fix(message.fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX)
            measurement = self.telemetry.see(message, arrival)
            if measurement is not None and arrival - measurement.stamp <= HISTORY:
                self.measurements.append(measurement)
                self.on_measurement(measurement, arrival)
        self.on_message(message, arrival)

    def _see_fix(self, fixed: bool) -> None:
        """Say when the receiver loses its fix and has one again; not before it had the first."""
        if self._fixed and not fixed:
            words = "the satellite receiver has lost its fix: positions may be dead reckoning"
            self._events.add(Level.WARNING, words)
        elif fixed and self._fixed is False:
            self._events.add(Level.INFO, "the satellite receiver has a fix again")
        if fixed or self._fixed:
            self._fixed = fixed

    def _restarted(self) -> None:
        self.telemetry.forget()
        self.requests.drop()
        self.ask_for_telemetry()
        self.on_restart()

    def _see_heartbeat(self, message: Any, arrival: float) -> None:
        if message.autopilot != self.heartbeat.autopilot:
            return  # of another program that speaks for this system
        if self._told_lost:
            self._told_lost = False
            self._events.add(Level.INFO, "the autopilot is heard again")
            self.ask_for_telemetry()
        self.heartbeat, self._heartbeat_at = message, arrival

    def tend(self, now: float) -> None:
        """Send what keeps the connection alive, where it is due.

        Args:
            now: Our time in [s].
        """
        if self._looked_at < now - 0.5 * STALL and not self.connection.wait(0.0):
            self._looked_at = now  # there was nothing to read
        if self.is_due("heartbeat", now, HEARTBEAT_PERIOD):
            self.connection.send(
                mavlink.MAVLink_heartbeat_message(
                    mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID,
                    0, 0, mavlink.MAV_STATE_ACTIVE, 3,
                )
            )  # fmt: skip
        if self.heartbeat is None:
            return
        if self.is_due("sync", now, SYNC_PERIOD):
            self._asked_at = int(now * 1e9)
            self.connection.send(mavlink.MAVLink_timesync_message(0, self._asked_at))
        silent = now - self._heartbeat_at
        if silent > LOST and not self._told_lost:
            self._told_lost = True
            self._events.add(Level.WARNING, f"the autopilot was not heard for {LOST:g} s")
        if self.is_due("telemetry", now, ASKING_PERIOD):
            self._watch_rate(now)
        self.requests.tend(now)

    def _watch_rate(self, now: float) -> None:
        """Ask for telemetry that is missing, or slowed down by another program such as MAVProxy."""
        usual, most = self._usual_rates, self._parameters.telemetry_rate
        rates = {kind: self._counted[kind] / (now - self._counted_at) for kind in COUNTED}
        slowed = any(rate < KEPT_RATE * usual[kind] for kind, rate in rates.items())
        self._usual_rates = {k: min(max(usual[k], rate), most) for k, rate in rates.items()}
        self._counted_at = now
        self._counted.clear()
        if slowed or self.telemetry.newest is None:
            self.ask_for_telemetry()

    def is_due(self, what: str, now: float, period: float) -> bool:
        """Whether something periodic is to be done; it then counts as done.

        Args:
            what: Its name.
            now: Our time in [s].
            period: In [s].
        """
        if now - self._due.get(what, -math.inf) < period:
            return False
        self._due[what] = now
        return True
