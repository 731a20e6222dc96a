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

"""An autopilot and its wire: what is said on it, and the faults that strike it."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence

from uav_tracking_mpc.autopilot.autopilot_core import AutopilotCore
from uav_tracking_mpc.autopilot.dialects.ardupilot import ArduPlane
from uav_tracking_mpc.autopilot.dialects.px4 import Px4
from uav_tracking_mpc.autopilot.ground_vehicle import GroundVehicle
from uav_tracking_mpc.autopilot.radio import Radio
from uav_tracking_mpc.autopilot.vehicle_protocol import VehicleProtocol
from uav_tracking_mpc.autopilot.wire_faults import WireFault, wire_fault
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import Configuration

DIALECTS: dict[str, type[AutopilotCore]] = {"ardupilot": ArduPlane, "px4": Px4}
ORIGIN = (47.3977, 8.5456, 488.0)  # deg, deg, m above sea level


class WiredAutopilot:
    """An autopilot that speaks and is struck by faults; whoever owns it makes its time go on.

    Args:
        dialect: ``ardupilot`` or ``px4``.
        configuration: Plant, air, start and what the aircraft can fly.
        radio: Makes its wire.
        origin: Latitude [deg], longitude [deg] and altitude above sea level [m] of the origin of
            ``map``, which is its home.
        system: Its MAVLink system.
        on_runway: It stands on the ground, disarmed, rather than loiters in the air.
        target_system: MAVLink system of a vehicle on the ground, which moves as the
            configuration's target and is heard on the same wire; 0 for none.

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
        radio: Callable[[], Radio],
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
        self.radio = radio()
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
