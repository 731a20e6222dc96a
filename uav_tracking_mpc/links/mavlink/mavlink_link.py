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

"""What all links to autopilots on MAVLink do alike; a file each says how its autopilot differs."""

from __future__ import annotations

import math
import threading
import time
from abc import abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.event import Level
from uav_tracking_mpc.dynamics.air import true_over_equivalent
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import Inspection, LinkError, Sighting, VehicleLink
from uav_tracking_mpc.links.mavlink.connection import Connection
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.engagement import Engagement, State
from uav_tracking_mpc.links.mavlink.findings import VehicleEnvelope, inspection
from uav_tracking_mpc.links.mavlink.listener import Listener
from uav_tracking_mpc.links.mavlink.requests import ask_for_parameters, value_of
from uav_tracking_mpc.settings.link import LinkParameters
from uav_tracking_mpc.simulation.plan_follower import PlanFollower

KEPT = 5000  # answers
AWAITED = 200  # measurements
SAME = 2e-3  # s by which the stamp of an answer may differ from its measurement's


class Latency:
    """Pairs answers with the arrival of what they answer."""

    def __init__(self) -> None:
        self._arrivals: deque[tuple[float, float]] = deque(maxlen=AWAITED)
        self._taken: deque[float] = deque(maxlen=KEPT)
        self._begin, self._count = math.inf, 0

    def arrived(self, stamp: float, arrival: float) -> None:
        """A measurement came.

        Args:
            stamp: Of the measurement in [s].
            arrival: When its last message came in [s].
        """
        self._arrivals.append((stamp, arrival))
        self._begin = min(self._begin, arrival)
        self._count += 1

    def answered(self, stamp: float, now: float) -> None:
        """A set-point was sent.

        Args:
            stamp: Of the measurement that it answers in [s].
            now: In [s].
        """
        for seen, arrival in reversed(self._arrivals):
            if abs(seen - stamp) <= SAME:
                self._taken.append(now - arrival)
                return

    def rate(self, now: float) -> float:
        """Measurements a second since the first, in [Hz].

        Args:
            now: In [s].
        """
        return self._count / (now - self._begin) if now > self._begin else 0.0

    def quantile(self, share: float) -> float:
        """Latency that this share of the answers kept, in [s]; 0 without any.

        Args:
            share: From 0 to 1 [-].
        """
        return float(np.quantile(list(self._taken), share)) if self._taken else 0.0


PERIOD = 0.02  # s between looks at what is due
BACKLOG = 1000  # reads in a row, after which what is due is looked at
LARGEST = 1e7  # m, m/s or rad/s: no number of an orbit on this earth is greater
ASKING_PERIOD = 1.0  # s between requests for the mode of external commands


class MavlinkLink(VehicleLink):
    """An autopilot on MAVLink.

    One thread asks for measurements; any may give commands.

    Args:
        address: See :class:`~uav_tracking_mpc.links.mavlink.connection.Connection`.
        parameters: What may be asked of it; its connection counts where the address is empty.
        connection: Makes the wire from address, component and key.

    Attributes:
        parameters: As above.
        engagement: Who flies.
        vehicle: The autopilot's parameters by name, in their own units.
        orbit: What is flown; None before the first command.
    """

    autopilot: ClassVar[int]  # of MAV_AUTOPILOT
    title: ClassVar[str]
    handed_over: ClassVar[tuple[str, ...]]  # modes from which command may be taken
    limits: ClassVar[type[VehicleEnvelope]]
    by_bits: ClassVar[bool] = False  # see value_of
    slow_messages: ClassVar[tuple[int, ...]] = ()
    quick_messages: ClassVar[tuple[int, ...]] = ()
    stream_period: ClassVar[float] = 0.04  # s after which a set-point is repeated

    def __init__(
        self,
        address: str = "",
        parameters: LinkParameters | None = None,
        connection: Callable[[str, int, str], Connection] = Connection,
    ) -> None:
        self._connected = connection
        self.parameters = parameters or LinkParameters()
        super().__init__(address or self.parameters.connection)
        self._lock = threading.RLock()
        self._heard: Listener | None = None
        self._forget()

    def _forget(self) -> None:
        by_mode = self._refused if self.parameters.engage_on_mode else None
        self.engagement = Engagement(self.events, by_mode)
        self.vehicle: dict[str, float] = {}
        self.orbit: FlownOrbit | None = None
        self._plan, self._latency = PlanFollower(), Latency()
        self._sent_at = -math.inf

    @classmethod
    def of(cls, parameters: LinkParameters) -> VehicleLink:
        """See :meth:`VehicleLink.of`."""
        return cls(parameters=parameters)

    # What differs from autopilot to autopilot ---------------------------------------------------

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
    def ask_for_command(self, now: float) -> None:
        """Ask the autopilot for its mode of external commands, once a second until it is there.

        Args:
            now: In [s].
        """

    @abstractmethod
    def fly(self, inputs: NDArray[np.float64], measured: Measurement, now: float) -> None:
        """Send what flies the inputs now.

        Args:
            inputs: (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2].
            measured: The newest measurement.
            now: In [s].
        """

    def begin(self, now: float) -> None:
        """What is to be done when our commands begin to fly.

        Args:
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

    def envelope(self) -> VehicleEnvelope:
        """Its limits where it flies."""
        return self.limits(self.vehicle, self.ratio)

    @property
    def ratio(self) -> float:
        """True over equivalent airspeed where it flies [-]."""
        return true_over_equivalent(self.heard.telemetry.altitude or 0.0)

    def refusal(self, orbit: FlownOrbit) -> str:
        """Why an orbit cannot be flown here, in words; empty if it can: what the fence says.

        Args:
            orbit: To be flown.
        """
        fence = self.envelope().fence()
        return "" if fence is None else fence.refusal(orbit, self.heard.telemetry)

    @property
    def heard(self) -> Listener:
        """What is heard of the autopilot.

        Raises:
            LinkError: It is not connected.
        """
        if self._heard is None:
            raise LinkError(f"{self.title} is not connected")
        return self._heard

    def connect(self, timeout: float) -> None:
        """See :meth:`VehicleLink.connect`."""
        self.close()
        self._forget()
        connection = self._connected(
            self.address, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER, self.parameters.signing_key
        )
        end = connection.now() + timeout
        self._heard = heard = Listener(
            connection, self.parameters, self.events, self.slow_messages, self.quick_messages
        )
        heard.on_measurement = lambda measured, at: self._latency.arrived(measured.stamp, at)
        heard.on_message = self._see
        heard.on_restart = lambda: self.engagement.give_up("the autopilot has restarted")
        try:
            heard.find(self.autopilot, timeout)
            names = self.limits.names
            ask_for_parameters(connection, heard.system, names, self.vehicle, heard.receive)
            # What is still missing at the end of the time, inspect() says.
            while self.now() < end and (
                heard.telemetry.newest is None or "AUTOPILOT_VERSION" not in heard.latest
            ):
                heard.receive(PERIOD)
                heard.tend(self.now())
        except LinkError:
            self.close()
            raise
        heard.measurements.clear()

    def close(self) -> None:
        """See :meth:`VehicleLink.close`."""
        with self._lock:  # a command that is being sent is sent before
            if self._heard is not None:
                self.disengage()
                self._heard.connection.close()
                self._heard = None

    def now(self) -> float:
        """See :meth:`VehicleLink.now`: the machine's monotonic clock, unless the wire has one."""
        heard = self._heard  # which another thread may close meanwhile
        return time.monotonic() if heard is None else heard.connection.now()

    def inspect(self) -> Inspection:
        """See :meth:`VehicleLink.inspect`: what was found, once everything was read."""
        mode = self.mode_name(self.heard.heartbeat.custom_mode)
        return inspection(self.heard, self.title, mode, self.handed_over, self.envelope())

    def measured(self, timeout: float) -> Measurement | None:
        """See :meth:`VehicleLink.measured`."""
        heard, end = self.heard, self.now() + timeout
        while not heard.measurements:
            left = end - self.now()
            heard.restore()
            if heard.connection.wait(min(max(left, 0.0), PERIOD)):
                with self._lock:
                    # All that waits: whoever falls behind is to fly by what came last.
                    for _ in range(BACKLOG):
                        if not heard.receive(0.0) or not heard.connection.wait(0.0):
                            break
            self._tend(self.now())
            if left <= 0.0:
                break
        return heard.measurements.popleft() if heard.measurements else None

    def command(
        self,
        stamp: float,
        inputs: NDArray[np.float64],
        step: float,
        orbit: FlownOrbit | None = None,
    ) -> str:
        """See :meth:`VehicleLink.command`."""
        if orbit is not None:
            numbers = np.hstack(orbit)  # of its own: the caller's arrays may change
            if numbers.shape != (10,) or not (np.abs(numbers) <= LARGEST).all():
                words = f"must be finite and within {LARGEST:g}, with points of shape (3,)"
                return f"the orbit is {orbit}, {words}"
            orbit = FlownOrbit(numbers[:3], numbers[3:6], *numbers[6:].tolist())
        now = self.now()
        with self._lock:
            try:
                inputs = np.asarray(inputs, dtype=float)
                self._plan.accept(inputs, stamp + step * np.arange(len(inputs)), now)
            except (ValueError, TypeError) as error:
                return str(error)
            if orbit is not None:
                self.orbit = orbit
                if self._heard is not None:
                    estimated = orbit.airspeed_now, orbit.surplus
                    self._heard.telemetry.see_estimate(*estimated, now)
            if self.engagement.commanding and self._heard is not None:
                self._fly(now)
                self._latency.answered(stamp, self.now())
        return ""

    @property
    def engaged(self) -> bool:
        """See :meth:`VehicleLink.engaged`."""
        return self.engagement.commanding

    def engage(self) -> str:
        """See :meth:`VehicleLink.engage`."""
        if self._heard is None or self._heard.heartbeat is None:
            return "there is no autopilot to engage"
        with self._lock:
            if words := self._refused():
                return words
            mode = self.mode_name(self._heard.heartbeat.custom_mode)  # that was looked at
            self.engagement.ask(self.now(), mode)
        return ""

    def _refused(self) -> str:
        """Why nothing can be commanded now, in words; empty where all is well."""
        refusals = list(self.inspect().refusals)
        if self.orbit is None:
            refusals.append("there is nothing to fly yet: no command has come")
        else:
            refusals.append(self.refusal(self.orbit))
        return "; ".join(filter(None, refusals))

    def disengage(self) -> None:
        """See :meth:`VehicleLink.disengage`."""
        with self._lock:
            if self.engagement.state is State.IDLE:
                return
            flown = self.engagement.commanding
            self.engagement.give_up("disengaged", Level.INFO)
            if self._heard is not None:
                self._heard.requests.drop()
                if flown:
                    self.let_go(self.now())

    def sighting(self) -> Sighting | None:
        """See :meth:`VehicleLink.sighting`."""
        return None if self._heard is None else self._heard.target.take()

    def values(self) -> dict[str, object]:
        """See :meth:`VehicleLink.values`."""
        if self._heard is None or self._heard.heartbeat is None:
            return {}
        heard, latency = self._heard, self._latency
        wind = None if heard.telemetry.wind is None else heard.telemetry.wind.tolist()
        return {
            "mode": self.mode_name(heard.heartbeat.custom_mode),
            "state": self.engagement.state.value,
            "rate [Hz]": latency.rate(self.now()),
            "latency median [ms]": 1e3 * latency.quantile(0.5),
            "latency p99 [ms]": 1e3 * latency.quantile(0.99),
            "messages lost": heard.connection.lost,
            "frames refused": heard.connection.bad,
            "commands refused": heard.requests.refused,
            "clock offset [s]": heard.clock.offset or 0.0,
            "clock jitter [ms]": 1e3 * heard.clock.jitter,
            "delay of the wire [ms]": 1e3 * heard.clock.delay,
            "wind by the autopilot [m/s]": wind,
            "restarts": heard.clock.restarts,
        }

    @property
    def _streams(self) -> bool:
        """Whether set-points are sent."""
        return self.engagement.state is not State.IDLE

    def _see(self, message: Any, arrival: float) -> None:
        """Take in any message of the autopilot."""
        self.engagement.heard(arrival)
        if message.get_type() == "PARAM_VALUE" and message.param_id in self.limits.names:
            value = value_of(message, self.by_bits)  # as it was asked for, or has been changed
            if math.isfinite(value):
                self.vehicle[message.param_id] = value
        if message is self.heard.heartbeat:  # not that of another program that speaks for it
            self._see_heartbeat(message, arrival)

    def _see_heartbeat(self, message: Any, arrival: float) -> None:
        was = self.engagement.commanding
        self.identity = self.heard.identity
        failsafe = message.system_status == mavlink.MAV_STATE_CRITICAL
        self._see_mode(message.custom_mode, arrival, failsafe)
        if self.engagement.commanding and not was:
            self.heard.requests.drop()  # what asked for the mode
            self.begin(arrival)

    def _see_mode(self, custom_mode: int, arrival: float, failsafe: bool) -> None:
        """Take in the mode that flies; repeated, a request would end one that a pilot has chosen.

        Args:
            custom_mode: Of the autopilot.
            arrival: Our time in [s].
            failsafe: Whether the autopilot says that it is in one.
        """
        ours, name = self.takes_commands(custom_mode), self.mode_name(custom_mode)
        self.engagement.see_mode(arrival, ours, name, self.heard.armed, failsafe)
        if not ours and self.engagement.state is State.IDLE:
            self.heard.requests.drop()

    def _tend(self, now: float) -> None:
        """Send what is due."""
        with self._lock:
            heard = self.heard
            if self.engagement.asked_long_enough(now):
                heard.requests.drop()
            state = self.engagement.state
            heard.tend(now)
            if state is State.ASKING and heard.is_due("command", now, ASKING_PERIOD):
                self.ask_for_command(now)
            if self._streams and now - self._sent_at >= self.stream_period:
                self._fly(now)
            if state is State.ENGAGED:
                self.accompany(now)

    def _fly(self, now: float) -> None:
        """Send what the plan asks for now; nothing where it is over."""
        inputs, measured = self._plan.inputs(now), self.heard.telemetry.newest
        if inputs is not None and measured is not None:
            self._sent_at = now
            self.fly(inputs, measured, now)
