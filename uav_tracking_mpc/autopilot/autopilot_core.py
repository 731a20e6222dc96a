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

"""An autopilot without its wire: an aircraft with modes, parameters and failsafes.

Everything here goes on by ticks, so that a test can step through a flight as quickly as it likes;
:mod:`~uav_tracking_mpc.autopilot.simulated_autopilot` puts it behind a wire and into real time.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar

from uav_tracking_mpc.autopilot.airframe import Airframe, FlightState
from uav_tracking_mpc.autopilot.flight_loops import Demand, FlightLoops, Response
from uav_tracking_mpc.autopilot.loiter import Loiter
from uav_tracking_mpc.autopilot.numbers import (
    AttitudeTarget,
    BaseMode,
    Frame,
    Order,
    Result,
    Severity,
    SystemState,
)
from uav_tracking_mpc.autopilot.onboard_parameters import OnboardParameters
from uav_tracking_mpc.autopilot.thrust import Engine
from uav_tracking_mpc.autopilot.wire_traits import WireTraits
from uav_tracking_mpc.dynamics.atmosphere import true_over_equivalent
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.settings.configuration import Configuration

TEXT_LENGTH = 50  # letters of STATUSTEXT


class AutopilotCore(ABC):
    """An aircraft that flies by modes.

    Args:
        configuration: Plant, air and start; the section of the controller says what the aircraft
            can fly, which becomes the autopilot's own parameters.
        origin: Of ``map``, and the aircraft's home.
        on_runway: Whether it stands on the ground, disarmed, rather than in the air.

    Attributes:
        modes: custom_mode by name, of those that can be flown.
        loiter_mode: In which it begins in the air.
        ground_mode: In which it stands on the ground.
        take_off_mode: In which it takes off once it is armed.
        traits: How it speaks.
        airframe: What flies.
        loops: Its inner loops.
        parameters: Of the autopilot.
        origin: As above.
        mode: Name of the present one.
        loiter: The circle that it flies in modes that circle.
        armed: Whether the engine may run.
        failsafe: Whether one is on.
        ground_heard: When a ground station was last heard, in [s]; None for never.
        clock_offset: Its clock since boot less the time since the start in [s].
        texts: Severity and words of what was said and not yet sent.
    """

    modes: ClassVar[Mapping[str, int]]
    loiter_mode: ClassVar[str]
    ground_mode: ClassVar[str]
    take_off_mode: ClassVar[str]
    traits: ClassVar[WireTraits]
    loiter: Loiter

    def __init__(
        self, configuration: Configuration, origin: LocalFrame, on_runway: bool = False
    ) -> None:
        self._configuration, self.origin = configuration, origin
        self.airframe = Airframe(configuration, on_runway)
        self.loops = FlightLoops(self.airframe, configuration.simulator)
        self.armed = not on_runway
        self.clock_offset = 0.0
        self._boot()

    def _boot(self) -> None:
        self.parameters = OnboardParameters(self.defaults(self._configuration, self.density_factor))
        self.failsafe = False
        self.ground_heard: float | None = None
        self.texts: list[tuple[Severity, str]] = []
        self.mode = self.loiter_mode if self.airframe.flying else self.ground_mode
        self.enter(self.mode)

    def restart(self) -> None:
        """Boot anew: clock, parameters and mode begin again; what was armed flies on."""
        self.clock_offset = -self.time
        self._boot()

    @property
    def state(self) -> FlightState:
        """As its loops see it."""
        return self.airframe.state

    @property
    def time(self) -> float:
        """Since the start in [s]."""
        return self.airframe.time

    @property
    def density_factor(self) -> float:
        """True over equivalent airspeed at its altitude [-]."""
        return true_over_equivalent(self.origin.altitude + self.state.up)

    @property
    def calibrated(self) -> float:
        """Airspeed as its sensor tells it, calibrated, in [m/s]."""
        return self.airframe.measured.airspeed / self.density_factor

    @property
    def custom_mode(self) -> int:
        """Number of the present mode, as HEARTBEAT has it."""
        return self.modes[self.mode]

    @property
    def intended_custom_mode(self) -> int:
        """Number of the mode that the pilot wants, also while a failsafe flies in another."""
        return self.custom_mode

    @property
    def system_state(self) -> SystemState:
        """As HEARTBEAT has it."""
        if self.failsafe:
            return SystemState.CRITICAL
        return SystemState.ACTIVE if self.airframe.flying else SystemState.STANDBY

    def step(self) -> None:
        """Go on by one tick."""
        self.watch()
        if self.airframe.flying:
            self.loops.fly(self.demand(), self.roll_response, self.engine)
            if not self.airframe.flying:
                self.armed = False
                self.say(Severity.EMERGENCY, "Crash: Disarming")
            return
        self.loops.stand(running=self.armed and self.mode == self.take_off_mode)
        if self.airframe.flying:
            self.enter(self.mode)

    def set_mode(self, mode: str) -> bool:
        """Change the mode, as a pilot's switch, a failsafe or a command does.

        Args:
            mode: Its name.

        Returns:
            Whether it is the mode now; entering it again changes nothing.
        """
        if mode == self.mode:
            return True
        if mode not in self.modes or not self.may_enter(mode):
            return False
        self.mode = mode
        self.enter(mode)
        return True

    def say(self, severity: Severity, words: str) -> None:
        """Tell the ground.

        Args:
            severity: Of the text.
            words: Cut where they are too long for one message.
        """
        self.texts.append((severity, words[:TEXT_LENGTH]))

    def altitude_in_map(self, altitude: float, frame: int) -> float | None:
        """Height in ``map`` in [m] of an altitude; None in frames that are not known.

        Args:
            altitude: In [m].
            frame: MAV_FRAME in which it is told.
        """
        if frame in (Frame.GLOBAL_RELATIVE_ALT, Frame.GLOBAL_RELATIVE_ALT_INT):
            altitude += self.origin.altitude
        elif frame not in (Frame.GLOBAL, Frame.GLOBAL_INT):
            return None
        # The earth falls away below the plane of map: 1.4 m in 4 km.
        state = self.state
        latitude, longitude, _ = self.origin.place([state.east, state.north, state.up])
        return float(self.origin.position(latitude, longitude, altitude)[2])

    def loiter_here(self, radius: float) -> Loiter:
        """A circle about where it is now.

        Args:
            radius: In [m], negative for counter-clockwise.
        """
        state = self.state
        return Loiter(state.east, state.north, state.up, abs(radius), radius >= 0.0)

    @classmethod
    @abstractmethod
    def defaults(cls, configuration: Configuration, density_factor: float) -> dict[str, float]:
        """Parameters at the start, by name [-].

        Args:
            configuration: Of the aircraft.
            density_factor: True over equivalent airspeed there [-].
        """

    @property
    @abstractmethod
    def base_mode(self) -> BaseMode:
        """As HEARTBEAT has it."""

    @property
    @abstractmethod
    def engine(self) -> Engine:
        """By the parameters."""

    @property
    @abstractmethod
    def roll_response(self) -> Response:
        """How its bank follows now."""

    @property
    @abstractmethod
    def least_interval(self) -> float:
        """Between two messages of one kind in [s]."""

    @abstractmethod
    def local(self, latitude: float, longitude: float) -> tuple[float, float]:
        """North and east in [m] as LOCAL_POSITION_NED has them: a projection of its own.

        Args:
            latitude: In [rad].
            longitude: In [rad].
        """

    @abstractmethod
    def mode_order(self, base_mode: int, custom_mode: int) -> Order:
        """The command that a SET_MODE message stands for.

        Args:
            base_mode: MAV_MODE_FLAG.
            custom_mode: As HEARTBEAT has it.
        """

    @abstractmethod
    def enter(self, mode: str) -> None:
        """Begin to fly a mode.

        Args:
            mode: Its name.
        """

    @abstractmethod
    def demand(self) -> Demand:
        """What the present mode asks for."""

    @abstractmethod
    def command(self, order: Order) -> Result:
        """Carry out a command, as far as it is none of the protocol itself.

        Args:
            order: The command.
        """

    @abstractmethod
    def attitude_target(self, target: AttitudeTarget) -> None:
        """Take in SET_ATTITUDE_TARGET.

        Args:
            target: As decoded.
        """

    @abstractmethod
    def watch(self) -> None:
        """Look after the failsafes, once a tick."""

    def may_enter(self, mode: str) -> bool:
        """Whether a mode may be entered now; says why where it may not.

        Args:
            mode: Its name.
        """
        return True

    def heard_heartbeat(self, system: int, ground_station: bool) -> None:
        """Take in the heartbeat of another system.

        Args:
            system: Its MAVLink system.
            ground_station: Whether it says that it is one.
        """
        if ground_station:
            self.ground_heard = self.time
