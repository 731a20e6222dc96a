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

"""An autopilot behind its wire: for tests, and for people without a build of one.

What is said on the wire and the faults that strike it stand in :class:`WiredAutopilot`, whose owner
makes time go on. :class:`SimulatedAutopilot` does so in real time. Beside it a second vehicle may
drive, which the aircraft is to circle.

:class:`SteppedAutopilot` flies in simulated time: flights of minutes take seconds, and repeat. Its
wire is two queues of datagrams in memory. Whoever waits at our end of it makes time go on, so a
link flies as it flies in real time, without threads, and the same seeds give the same flight.
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

from uav_tracking_mpc.autopilot.arduplane import ArduPlane
from uav_tracking_mpc.autopilot.autopilot_core import AutopilotCore
from uav_tracking_mpc.autopilot.deliveries import StreamRule
from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.px4 import Px4
from uav_tracking_mpc.autopilot.telemetry_messages import MessageRates, position_message
from uav_tracking_mpc.autopilot.vehicle_protocol import COMPONENT, VehicleProtocol
from uav_tracking_mpc.autopilot.wire_faults import AutopilotFault, Radio, wire_fault
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.links.mavlink.connection import Connection, Wire, open_wire, place_of
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import motion_of

RATES = {"HEARTBEAT": 1.0, "GLOBAL_POSITION_INT": 5.0}  # Hz
MODE_GUIDED_ARMED = 217  # bits of base_mode


class GroundVehicle:
    """Drives as a motion of targets says, and tells where it is.

    Args:
        parameters: Of the motion.
        origin: Of ``map``.
        system: Its MAVLink system.

    Raises:
        ParameterError: There is no such motion.
    """

    def __init__(self, parameters: TargetParameters, origin: LocalFrame, system: int) -> None:
        self._motion, self._origin = motion_of(parameters), origin
        self._rates = MessageRates(RATES)
        self._voice = mavlink.MAVLink(None, system, 1)

    def frames(self, now: float) -> list[bytes]:
        """What it says now, packed.

        Args:
            now: Since the start in [s].
        """
        return [bytes(self._message(name, now).pack(self._voice)) for name in self._rates.due(now)]

    def _message(self, name: str, now: float) -> Any:
        if name == "HEARTBEAT":
            return mavlink.MAVLink_heartbeat_message(
                mavlink.MAV_TYPE_GROUND_ROVER,
                mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
                MODE_GUIDED_ARMED,
                15,
                mavlink.MAV_STATE_ACTIVE,
                3,
            )
        position, velocity = self._motion.position(now), self._motion.velocity(now).tolist()
        yaw = math.atan2(*velocity[:2])
        return position_message(self._origin, round(now * 1e3), position, velocity, yaw)


DIALECTS: dict[str, type[AutopilotCore]] = {"ardupilot": ArduPlane, "px4": Px4}
ORIGIN = (47.3977, 8.5456, 488.0)  # deg, deg, m above sea level


class WiredAutopilot:
    """An autopilot that speaks and is struck by faults; whoever owns it makes its time go on.

    Args:
        dialect: ``ardupilot`` or ``px4``.
        configuration: Plant, air, start and what the aircraft can fly.
        connected: Makes its end of the wire, which suffers from the faults that it is given.
        origin: Latitude [deg], longitude [deg] and altitude above sea level [m] of the origin of
            ``map``, which is its home.
        system: Its MAVLink system.
        on_runway: It stands on the ground, disarmed, rather than loiters in the air.
        target_system: MAVLink system of a vehicle on the ground, which moves as the
            configuration's target and is heard on the same wire; 0 for none.

    Attributes:
        protocol: What speaks for it.
        radio: Its end of the wire.
        faults: That act on the wire.

    Raises:
        ParameterError: There is no such dialect, or no such place on the earth.
        LinkError: The connection cannot be opened.
    """

    def __init__(
        self,
        dialect: str,
        configuration: Configuration,
        connected: Callable[[list[StreamRule]], Connection],
        origin: Sequence[float] = ORIGIN,
        system: int = 1,
        on_runway: bool = False,
        target_system: int = 0,
    ) -> None:
        if dialect not in DIALECTS:
            raise ParameterError(f"dialect is {dialect!r}, must be one of {', '.join(DIALECTS)}")
        latitude, longitude, altitude = origin
        try:
            frame = LocalFrame(math.radians(latitude), math.radians(longitude), altitude)
        except ValueError as error:
            raise ParameterError(str(error)) from error
        core = DIALECTS[dialect](configuration, frame, on_runway)
        self.protocol = VehicleProtocol(core, system)
        self._target = (
            GroundVehicle(configuration.target, frame, target_system) if target_system else None
        )
        self.faults: list[StreamRule] = []
        self.radio = connected(self.faults)
        self.radio.speak_as(system)
        self._lock = threading.Lock()

    @property
    def core(self) -> AutopilotCore:
        """The autopilot itself."""
        return self.protocol.core

    def pilot_mode(self, mode: str) -> bool:
        """Change the mode as a pilot does by a switch.

        Args:
            mode: Its name.

        Returns:
            Whether it is the mode now.
        """
        with self._lock:
            return self.core.set_mode(mode)

    def restart(self) -> None:
        """Boot the autopilot anew in flight."""
        with self._lock:
            self.protocol.restart()

    def jump_clock(self, seconds: float) -> None:
        """Set the autopilot's clock.

        Args:
            seconds: By how much it goes forward in [s].
        """
        with self._lock:
            self.core.clock_offset += seconds

    def begin_fault(self, name: str, seed: int = 0) -> StreamRule:
        """Begin a fault on the wire.

        Args:
            name: One of :data:`~uav_tracking_mpc.autopilot.wire_faults.WIRE_FAULTS`.
            seed: Of everything random in it.

        Returns:
            The fault, which :meth:`end_fault` ends.

        Raises:
            ParameterError: There is none of that name.
        """
        fault = wire_fault(name, seed)
        if isinstance(fault, AutopilotFault):
            fault.begin(self)
        self.faults.append(fault)
        return fault

    def end_fault(self, fault: StreamRule) -> None:
        """End a fault.

        Args:
            fault: As it was begun.
        """
        self.faults.remove(fault)
        if isinstance(fault, AutopilotFault):
            fault.end(self)

    def go_on(self, now: float) -> None:
        """Fly up to a time and say what is to be said.

        Args:
            now: Since the start in [s].
        """
        with self._lock:
            self.protocol.advance(now)
            ready = self.protocol.outgoing()
        for message in ready:
            self.radio.send(message)
        if self._target is not None:
            for frame in self._target.frames(self.core.time):
                self.radio.relay(frame)

    def listen(self, timeout: float, clock: Callable[[], float]) -> None:
        """Take in what has come, and answer.

        Args:
            timeout: How long to wait for something in [s].
            clock: Time since the start in [s].

        Raises:
            LinkError: The wire is lost.
        """
        messages, now = self.radio.receive(timeout), clock()
        with self._lock:
            for message in messages:
                self.protocol.take(message, now)
            ready = self.protocol.outgoing()
        for message in ready:
            self.radio.send(message)


logger = logging.getLogger(__name__)

CONNECTION = "udpout:127.0.0.1:14550"
BEHIND = 1.0  # s by which the simulation may lag behind the clock before time stands still
RETRY = 0.2  # s between attempts to open a lost wire


class SimulatedAutopilot(WiredAutopilot):
    """Flies in a thread of its own from :meth:`start` to :meth:`stop`; also a context manager.

    Args:
        dialect: See :class:`WiredAutopilot`, as for the others.
        configuration: Of the mission.
        connection: As :class:`~uav_tracking_mpc.links.mavlink.connection.Connection` has it.
        origin: Latitude [deg], longitude [deg] and altitude [m] of the origin of ``map``.
        system: Its MAVLink system.
        on_runway: It stands on the ground.
        key: File with the key that signs messages; empty for none.
        target_system: MAVLink system of a vehicle on the ground; 0 for none.

    Raises:
        ParameterError: There is no such dialect, or no such place on the earth.
        LinkError: The connection cannot be opened.
    """

    def __init__(
        self,
        dialect: str,
        configuration: Configuration,
        connection: str = CONNECTION,
        origin: Sequence[float] = ORIGIN,
        system: int = 1,
        on_runway: bool = False,
        key: str = "",
        target_system: int = 0,
    ) -> None:
        def connected(faults: list[StreamRule]) -> Connection:
            wire = lambda: Radio(open_wire(*place_of(connection)), faults)  # noqa: E731
            return Connection(connection, COMPONENT, key, wire)

        super().__init__(
            dialect, configuration, connected, origin, system, on_runway, target_system
        )
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Fly in a thread."""
        self._thread = threading.Thread(target=self.run, name="simulated_autopilot", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the flight, wait for its thread and close the wire."""
        self._ending.set()
        if self._thread is not None:
            self._thread.join()
        self.radio.close()

    def __enter__(self) -> SimulatedAutopilot:
        """Start."""
        self.start()
        return self

    def __exit__(self, *error: object) -> None:
        """Stop."""
        self.stop()

    def run(self) -> None:
        """Fly by the machine's clock until :meth:`stop` is called."""
        begin = time.monotonic() - self.core.time
        while not self._ending.is_set():
            now = time.monotonic() - begin
            if now - self.core.time > BEHIND:  # the machine was busy: its time is lost
                begin += now - self.core.time - TICK
                now = self.core.time + TICK
            self.go_on(now)
            self._listen(begin)

    def _listen(self, begin: float) -> None:
        wait = self.core.time + TICK - (time.monotonic() - begin)
        try:
            self.listen(max(wait, 0.0), lambda: time.monotonic() - begin)
        except LinkError as error:
            logger.info("%s", error)
            try:
                self.radio.open()
            except LinkError:
                self._ending.wait(RETRY)


DATAGRAMS = "udpin:127.0.0.1:1"  # the form of an address; nothing is opened there
CAPACITY = 2000  # datagrams that wait; the oldest are dropped first, as a socket drops the newest


class _End(Wire):
    """One end of the wire; where somebody waits at it, time goes on."""

    def __init__(self, tick: Callable[[], None]) -> None:
        super().__init__(None)
        self.incoming: deque[bytes] = deque(maxlen=CAPACITY)
        self.other, self._tick = self, tick

    def write(self, frame: bytes) -> None:
        self.other.incoming.append(bytes(frame))

    def recv(self, size: int) -> bytes | None:
        return self.incoming.popleft() if self.incoming else None

    def select(self, timeout: float) -> bool:
        ticks = math.ceil(timeout / TICK)  # time moves on however short the wait
        while not self.incoming and ticks > 0:
            self._tick()
            ticks -= 1
        return bool(self.incoming)

    def close(self) -> None:
        self.incoming.clear()


class SteppedAutopilot(WiredAutopilot):
    """Goes on while a link that was made with :meth:`connection` waits.

    Args:
        dialect: See :class:`WiredAutopilot`.
        configuration: Of the mission.

    Attributes:
        time: Simulated, in [s].

    Raises:
        ParameterError: There is no such dialect.
    """

    def __init__(self, dialect: str, configuration: Configuration) -> None:
        self.time = 0.0
        self._ours, theirs = _End(self.tick), _End(self.tick)
        self._ours.other, theirs.other = theirs, self._ours
        super().__init__(
            dialect, configuration, lambda faults: self._connected(Radio(theirs, faults, self.now))
        )

    def now(self) -> float:
        """Simulated time in [s]."""
        return self.time

    def connection(self, address: str, component: int, key: str) -> Connection:
        """Our end of the wire.

        Args:
            address: Has no meaning here.
            component: MAVLink component that we are.
            key: Has no meaning here.
        """
        return self._connected(self._ours, component)

    def tick(self) -> None:
        """Go on by one tick."""
        self.time += TICK
        self.go_on(self.time)
        while self.radio.wait(0.0):
            self.listen(0.0, self.now)

    def _connected(self, wire: Wire, component: int = COMPONENT) -> Connection:
        return Connection(DATAGRAMS, component, wire=lambda: wire, clock=self.now)
