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

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

from uav_tracking_mpc.autopilot.airframe import Airframe, Engine, FlightState, load_factor
from uav_tracking_mpc.autopilot.flight_loops import Demand, FlightLoops, Loiter, Response
from uav_tracking_mpc.dynamics.air import true_over_equivalent
from uav_tracking_mpc.dynamics.energy_hold import HoldConstants
from uav_tracking_mpc.dynamics.frames import turn_rate_from_bank
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.links.mavlink.dialect import values_of
from uav_tracking_mpc.settings.configuration import Configuration

TEXT_LENGTH = 50  # letters of STATUSTEXT
Cmd, Frame, Result = values_of("MAV_CMD"), values_of("MAV_FRAME"), values_of("MAV_RESULT")
Severity, SystemState = values_of("MAV_SEVERITY"), values_of("MAV_STATE")
BaseMode = values_of("MAV_MODE_FLAG")
LARGEST = 2**31 - 1  # code, of the integers that PARAM_VALUE can hold


class OnboardParameters(dict[str, float]):
    """Values by name of at most 16 letters, in a fixed order; each keeps the type of its default.

    Args:
        defaults: Value of each at the start [-].
    """

    def __init__(self, defaults: Mapping[str, float]) -> None:
        super().__init__(sorted(defaults.items()))

    def integer(self, name: str) -> bool:
        """Whether a parameter is an integer.

        Args:
            name: One that exists.
        """
        return isinstance(self[name], int)

    def set(self, name: str, value: float) -> bool:
        """Change a value.

        Args:
            name: Of the parameter.
            value: New one [-]; rounded where the parameter is an integer.

        Returns:
            Whether there is such a parameter and the value is finite.
        """
        if name not in self or not math.isfinite(value):
            return False
        integer = self.integer(name)
        self[name] = min(max(round(value), -LARGEST - 1), LARGEST) if integer else float(value)
        return True


CLIMB_LAG = 1.0  # s, in which the climb rate follows that of the energy control
LOITER_BANK = math.radians(30.0)  # rad, with which a loiter is flown in still air, at most


class VehicleNumbers:
    """What an operator would have typed in for an aircraft.

    Args:
        configuration: What the controller is told of it, and its plant's limits.
        density_factor: True over equivalent airspeed at its start [-].

    Attributes:
        cruise: Calibrated airspeed in [m/s].
        slowest: Least calibrated airspeed in [m/s].
        fastest: Greatest calibrated airspeed in [m/s].
        bank_max: In [deg].
        climb_max: Greatest climb rate at cruise in [m/s].
        sink_max: Greatest sink rate in [m/s].
        sink_idle: Sink rate at cruise with the engine idle in [m/s].
        roll_rate: Greatest roll rate in [deg/s].
        radius: Of a loiter that leaves room for wind, in [m], in tens.
    """

    def __init__(self, configuration: Configuration, density_factor: float) -> None:
        envelope, plant = configuration.controller, configuration.simulator
        cruise = envelope.airspeed
        sink = cruise * math.sin(-envelope.path_angle_min)
        turn = cruise / turn_rate_from_bank(-LOITER_BANK, cruise)
        self.cruise = round(cruise / density_factor, 2)
        self.slowest = max(envelope.airspeed_min, plant.speed_min) / density_factor
        self.fastest = min(envelope.airspeed_max, plant.speed_max) / density_factor
        self.bank_max = round(math.degrees(min(envelope.bank_max, plant.bank_max)), 2)
        self.climb_max = round(cruise * math.sin(envelope.path_angle_max), 2)
        self.sink_max, self.sink_idle = round(sink, 2), round(min(2.0, 0.5 * sink), 2)
        self.roll_rate = round(math.degrees(min(envelope.roll_rate_max, 4.0)))
        self.radius = 10 * math.ceil(0.1 * turn)


class Order(NamedTuple):
    """A command as it came, COMMAND_LONG and COMMAND_INT alike.

    Attributes:
        command: MAV_CMD.
        param1: Its first value, in its own unit, [-].
        param2: Second [-].
        param3: Third [-].
        param4: Fourth [-].
        x: Latitude in [deg] where the command has a place, else its fifth value [-].
        y: Longitude in [deg], or the sixth value [-].
        z: Altitude in [m], or the seventh value [-].
        frame: MAV_FRAME of the place.
    """

    command: int
    param1: float = 0.0
    param2: float = 0.0
    param3: float = 0.0
    param4: float = 0.0
    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    frame: int = Frame.GLOBAL_RELATIVE_ALT


class AttitudeTarget(NamedTuple):
    """SET_ATTITUDE_TARGET, decoded.

    Attributes:
        mask: type_mask as on the wire: a bit that is set leaves its part out.
        roll: Of the quaternion in [rad], positive to the right.
        pitch: Of the quaternion in [rad], positive up.
        thrust: From 0 to 1 [-].
    """

    mask: int
    roll: float
    pitch: float
    thrust: float


class Traits(NamedTuple):
    """What one autopilot does and another does not.

    Attributes:
        mode_flags: Of MAV_MODE_FLAG, by mode, those that say how it is flown.
        meanings: Names of its parameters, by what they are for.
        maker: MAV_AUTOPILOT.
        version: Of the firmware that is imitated: major, minor, patch.
        capabilities: MAV_PROTOCOL_CAPABILITY.
        stream_rates: How often each message is sent that nobody asked for, in [Hz].
        mode_messages: Messages that are sent at once when the mode has changed.
        lacking: Messages that only the others have.
        sync_period: How often it asks for the time by TIMESYNC, in [s].
        unknown_message: Answer to a request for a message that there is none of.
        mode_refused: Answer to a command whose mode cannot be entered.
        hears_all: Whether commands to system 0 are carried out.
        bytewise: Whether integers travel as the bytes of a float.
        set_mode_acknowledged: The command that the answer to SET_MODE names.
    """

    mode_flags: Mapping[str, int]
    meanings: Mapping[str, str]
    maker: int
    version: tuple[int, int, int]
    capabilities: int
    stream_rates: Mapping[str, float]
    mode_messages: tuple[str, ...]
    lacking: tuple[str, ...]
    sync_period: float
    unknown_message: int
    mode_refused: int
    hears_all: bool
    bytewise: bool
    set_mode_acknowledged: int


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
        traits: How it speaks, and which parameters it goes by.
        answers: Carry out commands, by their numbers; each gives a MAV_RESULT.
        mode_commands: Modes that commands ask for, by their numbers.
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
    traits: ClassVar[Traits]
    answers: ClassVar[Mapping[int, Callable[[Any, Order], int]]]
    mode_commands: ClassVar[Mapping[int, str]]
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
        own = VehicleNumbers(self._configuration, self.density_factor)
        self.parameters = OnboardParameters(self.defaults(own))
        self.failsafe = False
        self.ground_heard: float | None = None
        self.texts: list[tuple[int, str]] = []
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
    def base_mode(self) -> int:
        """As HEARTBEAT has it."""
        mode = BaseMode.CUSTOM_MODE_ENABLED | self.traits.mode_flags[self.mode]
        if self.mode != "MANUAL":
            mode |= BaseMode.STABILIZE_ENABLED
        return int(mode | BaseMode.SAFETY_ARMED if self.armed else mode)

    @property
    def system_state(self) -> int:
        """As HEARTBEAT has it."""
        if self.failsafe:
            return int(SystemState.CRITICAL)
        return int(SystemState.ACTIVE if self.airframe.flying else SystemState.STANDBY)

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

    def say(self, severity: int, words: str) -> None:
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
        latitude, longitude, _ = self.origin.place(state.place)
        return float(self.origin.position(latitude, longitude, altitude)[2])

    def loiter_here(self, radius: float) -> Loiter:
        """A circle about where it is now.

        Args:
            radius: In [m], negative for counter-clockwise.
        """
        return Loiter(self.state.east, self.state.north, self.state.up, radius)

    def known(self, meaning: str, least: float = -math.inf) -> float:
        """A parameter by what it is for, in its own unit [SI or deg].

        Args:
            meaning: One of those of the traits.
            least: Below which it does not count, likewise.
        """
        return max(self.parameters[self.traits.meanings[meaning]], least)

    @property
    def engine(self) -> Engine:
        """By the parameters."""
        return Engine(
            cruise=self._configuration.controller.airspeed,
            trim=min(max(self.trim, 0.05), 0.95),
            climb_max=self.known("climb_max", 0.1),
            sink_idle=self.known("sink_idle", 0.1),
            load_energy=self.known("load_energy"),
        )

    def hold(self, up: float, airspeed: float, loaded: bool = True) -> tuple[float, float]:
        """u_chi in [rad/s] and u_v in [m/s^2] of its energy control.

        Args:
            up: Altitude to hold in ``map`` in [m].
            airspeed: To hold, calibrated, in [m/s], as far as it is one that may be flown.
            loaded: Whether the least airspeed grows with the load factor.
        """
        load = load_factor(self.loops.roll_wanted) if loaded else 1.0
        lowest = self.known("slowest") * math.sqrt(load)
        held = min(max(airspeed, lowest), self.known("fastest")) * self.density_factor
        constants = HoldConstants(
            height_time=self.known("height_time", 0.5),
            climb_time=CLIMB_LAG,
            airspeed_time=self.known("airspeed_time", 0.5),
            climb_max=self.known("climb_held", 0.1),
            sink_max=self.known("sink_held", 0.1),
            sink_idle=self.known("sink_idle", 0.1),
        )
        return self.loops.hold(up, held, constants)

    def mode_numbered(self, number: int) -> str | None:
        """Name of a mode; None for one that cannot be flown.

        Args:
            number: Its custom_mode.
        """
        return next((name for name, own in self.modes.items() if own == number), None)

    @classmethod
    @abstractmethod
    def defaults(cls, own: VehicleNumbers) -> dict[str, float]:
        """Parameters at the start, by name [-].

        Args:
            own: What an operator would have typed in for this aircraft.
        """

    @property
    @abstractmethod
    def trim(self) -> float:
        """Throttle of level flight at cruise here, from 0 to 1 [-]."""

    @property
    @abstractmethod
    def roll_response(self) -> Response:
        """How its bank follows now."""

    @property
    @abstractmethod
    def least_interval(self) -> float:
        """Between two messages of one kind in [s]."""

    def mode_order(self, base_mode: int, custom_mode: int) -> Order:
        """The command that a SET_MODE message stands for.

        Args:
            base_mode: MAV_MODE_FLAG.
            custom_mode: As HEARTBEAT has it.
        """
        return Order(Cmd.DO_SET_MODE, float(base_mode), float(custom_mode))

    @abstractmethod
    def enter(self, mode: str) -> None:
        """Begin to fly a mode.

        Args:
            mode: Its name.
        """

    @abstractmethod
    def demand(self) -> Demand:
        """What the present mode asks for."""

    def command(self, order: Order) -> int:
        """Carry out a command, as far as it is none of the protocol itself; MAV_RESULT.

        Args:
            order: The command.
        """
        if (mode := self.mode_commands.get(order.command)) is not None:
            return self.changed(self.set_mode(mode))
        answer = self.answers.get(order.command)
        return int(Result.UNSUPPORTED if answer is None else answer(self, order))

    def changed(self, done: bool) -> int:
        """MAV_RESULT of a change of mode.

        Args:
            done: Whether the mode was changed.
        """
        return int(Result.ACCEPTED if done else self.traits.mode_refused)

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
