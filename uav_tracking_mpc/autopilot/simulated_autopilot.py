"""An autopilot behind its wire, in real time: for tests, and for people without a build of one."""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Sequence

from uav_tracking_mpc.autopilot.autopilot_core import AutopilotCore
from uav_tracking_mpc.autopilot.dialects.ardupilot import ArduPlane
from uav_tracking_mpc.autopilot.dialects.px4 import Px4
from uav_tracking_mpc.autopilot.flight_loops import TICK
from uav_tracking_mpc.autopilot.radio import Radio
from uav_tracking_mpc.autopilot.vehicle_protocol import COMPONENT, VehicleProtocol
from uav_tracking_mpc.autopilot.wire_faults import WireFault, wire_fault
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration

logger = logging.getLogger(__name__)

DIALECTS: dict[str, type[AutopilotCore]] = {"ardupilot": ArduPlane, "px4": Px4}
CONNECTION = "udpout:127.0.0.1:14550"
ORIGIN = (47.3977, 8.5456, 488.0)  # deg, deg, m above sea level
BEHIND = 1.0  # s by which the simulation may lag behind the clock before time stands still
RETRY = 0.2  # s between attempts to open a lost wire


class SimulatedAutopilot:
    """Flies in a thread of its own from :meth:`start` to :meth:`stop`; also a context manager.

    Args:
        dialect: ``ardupilot`` or ``px4``.
        configuration: Plant, air, start and what the aircraft can fly.
        connection: As :class:`~uav_tracking_mpc.links.mavlink.connection.Connection` has it.
        origin: Latitude [deg], longitude [deg] and altitude above sea level [m] of the origin of
            ``map``, which is its home.
        system: Its MAVLink system.
        on_runway: It stands on the ground, disarmed, rather than loiters in the air.

    Attributes:
        protocol: What speaks for it.
        radio: Its wire, which faults strike.

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
        self.radio = Radio(connection, COMPONENT)
        self.radio.speak_as(system)
        self._lock = threading.Lock()
        self._ending = threading.Event()
        self._thread: threading.Thread | None = None

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

    def begin_fault(self, name: str, seed: int = 0) -> WireFault:
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
        fault.begin(self)
        self.radio.strike(fault)
        return fault

    def end_fault(self, fault: WireFault) -> None:
        """End a fault.

        Args:
            fault: As it was begun.
        """
        self.radio.release(fault)
        fault.end(self)

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
            with self._lock:
                self.protocol.advance(now)
                ready = self.protocol.outgoing()
            for message in ready:
                self.radio.send(message)
            self._listen(begin)

    def _listen(self, begin: float) -> None:
        wait = self.core.time + TICK - (time.monotonic() - begin)
        try:
            messages = self.radio.receive(max(wait, 0.0))
        except LinkError as error:
            logger.info("%s", error)
            self._reopen()
            return
        now = time.monotonic() - begin
        with self._lock:
            for message in messages:
                self.protocol.take(message, now)
            ready = self.protocol.outgoing()
        for message in ready:
            self.radio.send(message)

    def _reopen(self) -> None:
        try:
            self.radio.open()
        except LinkError:
            self._ending.wait(RETRY)
