"""What all links to autopilots on MAVLink do alike; a file each says how its autopilot differs."""

from __future__ import annotations

import math
import threading
import time
from abc import abstractmethod
from collections import deque
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import Inspection, LinkError, LinkRefusedError, Sighting, VehicleLink
from uav_tracking_mpc.links.mavlink.autopilot_clock import AutopilotClock
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink, name_of
from uav_tracking_mpc.links.mavlink.engagement import Engagement, State
from uav_tracking_mpc.links.mavlink.latency import Latency
from uav_tracking_mpc.links.mavlink.requests import Requests
from uav_tracking_mpc.links.mavlink.telemetry import LEAST_AIRSPEED, Telemetry
from uav_tracking_mpc.links.mavlink.vehicle_parameters import read_parameters
from uav_tracking_mpc.links.mavlink.vehicle_sighting import VehicleSighting
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.plan_follower import PlanFollower

FIXED_WING = {
    mavlink.MAV_TYPE_FIXED_WING,
    *(value for value, entry in mavlink.enums["MAV_TYPE"].items() if "VTOL" in entry.name),
}
PERIOD = 0.02  # s between looks at what is due
STREAM_PERIOD = 0.04  # s after which a set-point is repeated
HEARTBEAT_PERIOD, SYNC_PERIOD, SLOW_PERIOD = 1.0, 0.5, 1.0  # s
SLOW_RATE = 2.0  # Hz, of what changes slowly
REOPEN_PERIOD = 1.0  # s between attempts to open a lost wire
LOST = 5.0  # s without a heartbeat
SEVERE = 4  # MAV_SEVERITY from which on the autopilot's words are warnings


class MavlinkLink(VehicleLink):
    """An autopilot on MAVLink.

    Args:
        address: See :class:`Connection`.
        parameters: What may be asked of it; its connection counts where the address is empty.
    """

    autopilot: ClassVar[int]  # of MAV_AUTOPILOT
    title: ClassVar[str]
    asked_parameters: ClassVar[tuple[str, ...]]
    by_bits: ClassVar[bool] = False  # see value_of
    messages: ClassVar[tuple[int, ...]] = (
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_ATTITUDE,
        mavlink.MAVLINK_MSG_ID_VFR_HUD,
    )
    slow_messages: ClassVar[tuple[int, ...]] = ()

    def __init__(self, address: str = "", parameters: LinkParameters | None = None) -> None:
        self.parameters = parameters or LinkParameters()
        super().__init__(address or self.parameters.connection)
        self._lock = threading.RLock()
        self.clock = AutopilotClock()
        origin = self.parameters.origin
        frame = None
        if origin:
            latitude, longitude, altitude = origin
            frame = LocalFrame(math.radians(latitude), math.radians(longitude), altitude)
        self.telemetry = Telemetry(self.clock, frame)
        self.engagement = Engagement(self.events, self.parameters.engage_on_mode)
        self.latency = Latency()
        self.vehicle: dict[str, float] = {}
        self.version: Any = None
        self.status: Any = None  # EKF_STATUS_REPORT or ESTIMATOR_STATUS
        self.sensors: Any = None  # SYS_STATUS
        self.landed: Any = None  # EXTENDED_SYS_STATE
        self._connection: Connection | None = None
        self._target = VehicleSighting()
        self._forget()

    def _forget(self) -> None:
        self._plan = PlanFollower()
        self.orbit: FlownOrbit | None = None
        self._ready: deque[Measurement] = deque(maxlen=4)
        self._heartbeat_at = self._sent_at = self._reopened_at = -math.inf
        self._asked_at, self._told_lost = 0, False
        self.heartbeat: Any = None
        self._due = {"heartbeat": -math.inf, "sync": -math.inf, "slow": -math.inf}

    @classmethod
    def of(cls, parameters: LinkParameters) -> VehicleLink:
        """See :meth:`VehicleLink.of`."""
        return cls(parameters=parameters)

    # What an autopilot says of itself -----------------------------------------------------------

    @abstractmethod
    def mode_name(self, custom_mode: int) -> str:
        """Name of a mode.

        Args:
            custom_mode: Of its HEARTBEAT.
        """

    @abstractmethod
    def takes_commands(self, custom_mode: int) -> bool:
        """Whether a mode is that of external commands.

        Args:
            custom_mode: Of its HEARTBEAT.
        """

    @abstractmethod
    def describe(self) -> Inspection:
        """What was found, and the envelope that follows, once everything was read."""

    @abstractmethod
    def refusal(self, orbit: FlownOrbit) -> str:
        """Why an orbit cannot be flown here, in words; empty if it can.

        Args:
            orbit: To be flown.
        """

    @abstractmethod
    def ask_for_command(self, now: float) -> None:
        """Ask the autopilot for its mode of external commands, once a second until it is there.

        Args:
            now: In [s].
        """

    @abstractmethod
    def fly(self, inputs: NDArray[np.float64], now: float) -> None:
        """Send what flies the inputs now.

        Args:
            inputs: (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2].
            now: In [s].
        """

    def accompany(self, now: float) -> None:
        """What is to be sent now and then while our commands fly.

        Args:
            now: In [s].
        """

    def let_go(self, now: float) -> None:
        """What is to be sent when our commands end while the mode is still ours.

        Args:
            now: In [s].
        """

    # VehicleLink --------------------------------------------------------------------------------

    @property
    def connection(self) -> Connection:
        """The wire.

        Raises:
            LinkError: It is not connected.
        """
        if self._connection is None:
            raise LinkError(f"{self.title} is not connected")
        return self._connection

    def connect(self, timeout: float) -> None:
        """See :meth:`VehicleLink.connect`."""
        self.close()
        self._forget()
        key = self.parameters.signing_key
        self._connection = Connection(self.address, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER, key)
        self.requests = Requests(self._connection, self.events)
        end = self.now() + timeout
        try:
            self._find(end, timeout)
            self._ask_for_telemetry()
            self.vehicle = read_parameters(
                self._connection,
                self.requests.system,
                self.asked_parameters,
                self.by_bits,
                self._receive,
            )
            while self.telemetry.newest is None or self.version is None:
                if self.now() > end:
                    break  # what is missing is said by inspect()
                self.measured(0.1)
        except LinkError:
            self.close()
            raise
        self._ready.clear()

    def _find(self, end: float, timeout: float) -> None:
        """Wait for the heartbeat of an autopilot that this link can fly."""
        others: set[str] = set()
        while self.heartbeat is None:
            if self.now() > end:
                words = f"no autopilot answers at {self.connection.address!r} within {timeout:g} s"
                if others:
                    words += f"; heard there: {', '.join(sorted(others))}"
                if self.connection.bad:
                    words += f"; {self.connection.bad} frames were garbled or wrongly signed"
                raise LinkError(words)
            self._tend(self.now())
            for message in self.connection.receive(0.1):
                if message.get_type() != "HEARTBEAT":
                    continue
                system = message.get_srcSystem()
                if message.autopilot == mavlink.MAV_AUTOPILOT_INVALID or (
                    self.parameters.system and system != self.parameters.system
                ):
                    others.add(f"system {system}, {name_of('MAV_TYPE', message.type)}")
                    continue
                self._accept(message, system)

    def _accept(self, message: Any, system: int) -> None:
        firmware = name_of("MAV_AUTOPILOT", message.autopilot)
        kind = name_of("MAV_TYPE", message.type)
        if message.autopilot != self.autopilot:
            raise LinkRefusedError(
                f"system {system} at {self.connection.address!r} is {firmware}, must be "
                f"{name_of('MAV_AUTOPILOT', self.autopilot)} for link '{self.name}'"
            )
        if message.type not in FIXED_WING:
            raise LinkRefusedError(
                f"system {system} at {self.connection.address!r} is a {kind}, must be a fixed wing"
            )
        self.requests.system = self.connection.watched = system
        self.connection.speak_as(system)
        self.heartbeat, self._heartbeat_at = message, self.now()

    def _ask_for_telemetry(self) -> None:
        connection = self.connection
        rates = dict.fromkeys(self.messages, self.parameters.telemetry_rate)
        rates.update(dict.fromkeys(self.slow_messages, SLOW_RATE))
        for message, rate in rates.items():
            # Without waiting for each other's acknowledgement, of which there is one of a kind.
            connection.send(
                mavlink.MAVLink_command_long_message(
                    self.requests.system, 1, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0,
                    message, 1e6 / rate, 0, 0, 0, 0, 0,
                )
            )  # fmt: skip
        for message in (
            mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION,
            mavlink.MAVLINK_MSG_ID_HOME_POSITION,
        ):
            connection.send(
                mavlink.MAVLink_command_long_message(
                    self.requests.system, 1, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, message,
                    0, 0, 0, 0, 0, 0,
                )
            )  # fmt: skip

    def close(self) -> None:
        """See :meth:`VehicleLink.close`."""
        if self._connection is not None:
            self.disengage()
            self._connection.close()
            self._connection = None

    def now(self) -> float:
        """See :meth:`VehicleLink.now`: the machine's monotonic clock."""
        return time.monotonic()

    def inspect(self) -> Inspection:
        """See :meth:`VehicleLink.inspect`."""
        if self.heartbeat is None:
            raise LinkError(f"{self.title} is not connected")
        return self.describe()

    def measured(self, timeout: float) -> Measurement | None:
        """See :meth:`VehicleLink.measured`."""
        end = self.now() + timeout
        while not self._ready:
            left = end - self.now()
            self._receive(min(max(left, 0.0), PERIOD))
            self._tend(self.now())
            if left <= 0.0:
                break
        return self._ready.popleft() if self._ready else None

    def command(
        self,
        stamp: float,
        inputs: NDArray[np.float64],
        step: float,
        orbit: FlownOrbit | None = None,
    ) -> str:
        """See :meth:`VehicleLink.command`."""
        if orbit is not None and not _finite(orbit):
            return f"the orbit is {orbit}, must be finite"
        now = self.now()
        with self._lock:
            try:
                inputs = np.asarray(inputs, dtype=float)
                self._plan.accept(inputs, stamp + step * np.arange(len(inputs)), now)
            except (ValueError, TypeError) as error:
                return str(error)
            if orbit is not None:
                self.orbit = orbit
            if self.engagement.commanding:
                self._fly(now)
                self.latency.answered(stamp, self.now())
        return ""

    @property
    def engaged(self) -> bool:
        """See :meth:`VehicleLink.engaged`."""
        return self.engagement.commanding

    def engage(self) -> str:
        """See :meth:`VehicleLink.engage`."""
        if self._connection is None or self.heartbeat is None:
            return "there is no autopilot to engage"
        with self._lock:
            refusals = self.describe().refusals
            if not refusals and self.orbit is None:
                return "there is nothing to fly yet: no command has come"
            if not refusals and self.orbit is not None:
                refusals = tuple(filter(None, [self.refusal(self.orbit)]))
            if refusals:
                return "; ".join(refusals)
            self.engagement.ask(self.now())
        return ""

    def disengage(self) -> None:
        """See :meth:`VehicleLink.disengage`."""
        with self._lock:
            if self.engagement.state is not State.IDLE:
                flown = self.engagement.commanding
                self.engagement.give_up("disengaged")
                self.requests.drop()
                if flown:
                    self.let_go(self.now())

    def sighting(self) -> Sighting | None:
        """See :meth:`VehicleLink.sighting`."""
        return self._target.take()

    def values(self) -> dict[str, object]:
        """See :meth:`VehicleLink.values`."""
        heartbeat, connection = self.heartbeat, self._connection
        return {
            "dialect": self.name,
            "mode": "" if heartbeat is None else self.mode_name(heartbeat.custom_mode),
            "state": self.engagement.state.value,
            "rate [Hz]": self.latency.rate(self.now()),
            "latency median [ms]": 1e3 * self.latency.quantile(0.5),
            "latency p99 [ms]": 1e3 * self.latency.quantile(0.99),
            "messages lost": 0 if connection is None else connection.lost,
            "frames refused": 0 if connection is None else connection.bad,
            "commands refused": 0 if connection is None else self.requests.refused,
            "clock offset [s]": self.clock.offset or 0.0,
            "clock jitter [ms]": 1e3 * self.clock.jitter,
            "restarts": self.clock.restarts,
        }

    # What comes in ------------------------------------------------------------------------------

    def _receive(self, timeout: float) -> list[Any]:
        """The autopilot's messages, taken in; the wire is opened anew if it was lost."""
        try:
            messages = self.connection.receive(timeout)
        except LinkError as error:
            self._reopen(str(error), timeout)
            return []
        arrival, own = self.now(), []
        for message in messages:
            system, component = message.get_srcSystem(), message.get_srcComponent()
            with self._lock:
                if system == self.requests.system and component == 1:
                    own.append(message)
                    self._see(message, arrival)
                elif system == self.parameters.target_system and self.telemetry.frame is not None:
                    self._target.see(message, arrival, self.telemetry.frame)
        return own

    def _reopen(self, words: str, timeout: float) -> None:
        if self._connection is None:
            raise LinkError(f"{self.title} is not connected")
        now = self.now()
        if now - self._reopened_at < REOPEN_PERIOD:
            time.sleep(min(timeout, PERIOD))
            return
        if self._reopened_at == -math.inf:
            self.events.add(Level.WARNING, words)
        self._reopened_at = now
        try:
            self._connection.open()
        except LinkError:
            return
        self._connection.speak_as(self.requests.system)
        self._reopened_at = -math.inf

    def _see(self, message: Any, arrival: float) -> None:
        """Take in a message of the autopilot."""
        kind = message.get_type()
        self.engagement.heard(arrival)
        if hasattr(message, "time_boot_ms"):
            restarts = self.clock.restarts
            self.clock.see_stamp(message.time_boot_ms * 1e-3, arrival)
            if self.clock.restarts != restarts:
                self._restarted()
        if kind == "HEARTBEAT":
            self._see_heartbeat(message, arrival)
        elif kind == "TIMESYNC" and message.tc1 > 0 and message.ts1 == self._asked_at:
            self.clock.see_answer(message.ts1 * 1e-9, message.tc1 * 1e-9, arrival)
        elif kind == "COMMAND_ACK":
            self.requests.see(message, arrival)
        elif kind == "AUTOPILOT_VERSION":
            self.version = message
        elif kind in ("EKF_STATUS_REPORT", "ESTIMATOR_STATUS"):
            self.status = message
        elif kind == "SYS_STATUS":
            self.sensors = message
        elif kind == "EXTENDED_SYS_STATE":
            self.landed = message
        elif kind == "STATUSTEXT":
            level = Level.WARNING if message.severity <= SEVERE else Level.INFO
            self.events.add(level, f"autopilot: {message.text}")
        else:
            measurement = self.telemetry.see(message, arrival)
            if measurement is not None:
                self._ready.append(measurement)
                self.latency.arrived(measurement.stamp, arrival)

    def _restarted(self) -> None:
        self.engagement.give_up("the autopilot has restarted")
        self.telemetry.forget()
        self.requests.drop()
        self._ask_for_telemetry()

    def _see_heartbeat(self, message: Any, arrival: float) -> None:
        if message.autopilot != self.autopilot:
            return  # another program on the same system
        if self._told_lost:
            self._told_lost = False
            self.events.add(Level.INFO, "the autopilot is heard again")
            self._ask_for_telemetry()
        self.heartbeat, self._heartbeat_at = message, arrival
        was = self.engagement.commanding
        self.engagement.see_mode(
            arrival,
            self.takes_commands(message.custom_mode),
            self.mode_name(message.custom_mode),
            bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED),
            message.system_status == mavlink.MAV_STATE_CRITICAL,
        )
        if self.engagement.commanding and not was:
            self.begin(arrival)

    def begin(self, now: float) -> None:
        """What is to be sent when our commands begin to fly.

        Args:
            now: In [s].
        """

    # What goes out ------------------------------------------------------------------------------

    def _tend(self, now: float) -> None:
        """Send what is due."""
        with self._lock:
            if self._is_due("heartbeat", now, HEARTBEAT_PERIOD):
                self.connection.send(
                    mavlink.MAVLink_heartbeat_message(
                        mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID,
                        0, 0, mavlink.MAV_STATE_ACTIVE, 3,
                    )
                )  # fmt: skip
            if self.heartbeat is None:
                return
            if self._is_due("sync", now, SYNC_PERIOD):
                self._asked_at = int(now * 1e9)
                self.connection.send(mavlink.MAVLink_timesync_message(0, self._asked_at))
            if now - self._heartbeat_at > LOST and not self._told_lost:
                self._told_lost = True
                self.events.add(Level.WARNING, f"the autopilot was not heard for {LOST:g} s")
            self.requests.tend(now)
            state = self.engagement.state
            if state is State.ASKING and self._is_due("slow", now, SLOW_PERIOD):
                self.ask_for_command(now)
            if state is not State.IDLE and now - self._sent_at >= STREAM_PERIOD:
                self._fly(now)
            if state is State.ENGAGED:
                self.accompany(now)

    def _is_due(self, what: str, now: float, period: float) -> bool:
        if now - self._due[what] < period:
            return False
        self._due[what] = now
        return True

    def _fly(self, now: float) -> None:
        """Send what the plan asks for now; nothing where it is over."""
        inputs = self._plan.inputs(now)
        if inputs is not None and self.telemetry.newest is not None:
            self._sent_at = now
            self.fly(inputs, now)

    @property
    def in_air(self) -> bool:
        """Whether the autopilot says so or, if it says nothing of it, flies by its airspeed."""
        if self.landed is not None and self.landed.landed_state:
            return bool(self.landed.landed_state != mavlink.MAV_LANDED_STATE_ON_GROUND)
        return (self.telemetry.airspeed or 0.0) >= LEAST_AIRSPEED


def _finite(orbit: FlownOrbit) -> bool:
    return bool(np.isfinite([*orbit.centre, *orbit.velocity, orbit.radius, orbit.airspeed]).all())
