"""An autopilot without its wire: an aircraft with modes, parameters and failsafes.

Everything here goes on by ticks, so that a test can step through a flight as quickly as it likes;
:mod:`~uav_tracking_mpc.autopilot.simulated_autopilot` puts it behind a wire and into real time.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from uav_tracking_mpc.autopilot.airframe import Airframe, FlightState
from uav_tracking_mpc.autopilot.loiter import Loiter, LoiterLaw
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
from uav_tracking_mpc.dynamics.atmosphere import true_over_equivalent
from uav_tracking_mpc.dynamics.energy_hold import HoldConstants, hold
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.settings.configuration import Configuration

TICK = 0.01  # s: 100 Hz, above the 50 Hz at which ArduPlane runs its main loop by default
FORCED_DISARM = 21196.0  # of MAV_CMD_COMPONENT_ARM_DISARM
TEXT_LENGTH = 50  # letters of STATUSTEXT


class Demand(NamedTuple):
    """What a mode asks of the inner loops.

    Attributes:
        roll: To the right in [rad].
        climb: u_chi in [rad/s].
        acceleration: u_v in [m/s^2].
    """

    roll: float
    climb: float
    acceleration: float


class AutopilotCore(ABC):
    """An aircraft that flies by modes.

    Args:
        configuration: Plant, air and start; the section of the controller says what the aircraft
            can fly, which becomes the autopilot's own parameters.
        origin: Of ``map``, and the aircraft's home.
        on_runway: Whether it stands on the ground, disarmed, rather than in the air.

    Attributes:
        modes: custom_mode by name, of those that can be flown.
        airframe: What flies.
        parameters: Of the autopilot.
        origin: As above.
        mode: Name of the present one.
        armed: Whether the engine may run.
        failsafe: Whether one is on.
        throttle: From 0 to 1 [-].
        roll_wanted: Bank that the mode asks for in [rad].
        clock_offset: Its clock since boot less the time since the start in [s].
        texts: Severity and words of what was said and not yet sent.
    """

    modes: ClassVar[Mapping[str, int]]
    loiter_mode: ClassVar[str]
    ground_mode: ClassVar[str]
    off_the_ground: ClassVar[tuple[str, ...]]
    disarm_in_flight: ClassVar[Result]
    maker: ClassVar[int]  # MAV_AUTOPILOT
    version: ClassVar[tuple[int, int, int]]
    capabilities: ClassVar[int]
    stream_rates: ClassVar[Mapping[str, float]]  # Hz of each message that nobody asked for
    mode_messages: ClassVar[tuple[str, ...]]  # that are sent at once when the mode has changed
    sync_period: ClassVar[float]  # s, in which it asks for the time by TIMESYNC
    unknown_message: ClassVar[Result]  # to a request for a message that there is none of
    hears_all: ClassVar[bool]  # whether commands to system 0 count
    bytewise: ClassVar[bool]  # whether integers travel as the bytes of a float
    set_mode_acknowledged: ClassVar[int]  # the command in the answer to SET_MODE

    def __init__(
        self, configuration: Configuration, origin: LocalFrame, on_runway: bool = False
    ) -> None:
        self.airframe = Airframe(configuration, on_runway)
        self.origin = origin
        self.parameters = OnboardParameters(self.defaults(configuration, self.density_factor))
        self._configuration = configuration
        self._law = LoiterLaw()
        self._bank = 0.0 if on_runway else self.state.roll  # that the roll loop asks for now
        self.armed, self.failsafe = not on_runway, False
        self.throttle = self.roll_wanted = self.clock_offset = 0.0
        self.texts: list[tuple[Severity, str]] = []
        self.mode = self.ground_mode if on_runway else self.loiter_mode
        self.enter(self.mode)

    @property
    def state(self) -> FlightState:
        """As its loops see it."""
        return self.airframe.state

    @property
    def time(self) -> float:
        """Since the start in [s]."""
        return self.airframe.time

    @property
    def calibrated(self) -> float:
        """Airspeed as its sensor tells it, calibrated, in [m/s]."""
        return self.airframe.measured.airspeed / self.density_factor

    @property
    def density_factor(self) -> float:
        """True over equivalent airspeed at its altitude [-]."""
        return true_over_equivalent(self.origin.altitude + self.state.up)

    @property
    def custom_mode(self) -> int:
        """Number of the present mode, as HEARTBEAT has it."""
        return self.modes[self.mode]

    @property
    def system_state(self) -> SystemState:
        """As HEARTBEAT has it."""
        if self.failsafe:
            return SystemState.CRITICAL
        return SystemState.ACTIVE if self.airframe.flying else SystemState.STANDBY

    def step(self) -> None:
        """Go on by one tick."""
        self.watch()
        if not self.airframe.flying:
            self.throttle = 0.0
            if self.armed and self.mode in self.off_the_ground:
                self.throttle = 1.0
                self.airframe.run(TICK)
                if self.airframe.flying:
                    self._bank = 0.0
                    self.enter(self.mode)
            else:
                self.airframe.stand(TICK)
            return
        demand = self.fly()
        speed = max(self.state.airspeed, 1.0)
        lag, rate = self.roll_response
        limit = self.roll_limit
        self.roll_wanted = min(max(demand.roll, -limit), limit)
        # What the plant lags behind is already part of the loop's time constant.
        own, *_ = self._configuration.simulator.rate_lag
        change = (self.roll_wanted - self._bank) / max(lag - own, TICK)
        self._bank += TICK * min(max(change, -rate), rate)
        steepest = self._configuration.simulator.pitch_rate_max
        climb = min(max(demand.climb, -steepest), steepest)
        turn = -GRAVITY * math.tan(self._bank) / speed  # the coordinated turn, to the left positive
        force = demand.acceleration + GRAVITY * math.sin(self.state.path_angle)
        self.throttle = self.engine.throttle(force, self.state.airspeed)
        self.airframe.fly((turn, climb, demand.acceleration), TICK)
        if not self.airframe.flying:
            self.armed = False
            self.say(Severity.EMERGENCY, "Crash: Disarming")

    def hold(self, up: float, calibrated: float, constants: HoldConstants) -> tuple[float, float]:
        """u_chi in [rad/s] and u_v in [m/s^2] that lead to an altitude and an airspeed.

        Args:
            up: Altitude to hold in ``map`` in [m].
            calibrated: Airspeed to hold, calibrated, in [m/s].
            constants: Of the energy control.
        """
        state = self.state
        return hold(
            up - state.up,
            state.up_rate,
            state.path_angle,
            state.airspeed,
            calibrated * self.density_factor - state.airspeed,
            constants,
            math,
        )

    def by_pitch(self, pitch: float, lag: float) -> float:
        """u_chi in [rad/s] of a pitch that is held instead of an altitude.

        Args:
            pitch: Of the nose, up, in [rad].
            lag: Of the path angle behind the pitch in [s].
        """
        state = self.state
        incidence = self.airframe.angle_of_attack(state.airspeed, state.roll)
        return (pitch - incidence - state.path_angle) / lag

    def by_throttle(self, throttle: float) -> float:
        """u_v in [m/s^2] of a throttle that is held instead of an airspeed.

        Args:
            throttle: From 0 to 1 [-].
        """
        state = self.state
        force = self.engine.force(throttle, state.airspeed)
        return force - GRAVITY * math.sin(state.path_angle)

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
        if frame in (Frame.GLOBAL, Frame.GLOBAL_INT):
            return altitude - self.origin.altitude
        if frame in (Frame.GLOBAL_RELATIVE_ALT, Frame.GLOBAL_RELATIVE_ALT_INT):
            return altitude
        return None

    def loiter_here(self, radius: float) -> Loiter:
        """A circle about where it is now.

        Args:
            radius: In [m], negative for counter-clockwise.
        """
        state = self.state
        return Loiter(state.east, state.north, state.up, abs(radius), radius >= 0.0)

    def bank_to(self, loiter: Loiter, period: float, damping: float) -> float:
        """Bank in [rad] that leads onto a circle.

        Args:
            loiter: The circle.
            period: Of the L1 law in [s].
            damping: Of the L1 law [-].
        """
        return self._law.bank(self.state, loiter, period, damping)

    def arm(self, order: Order) -> Result:
        """Answer MAV_CMD_COMPONENT_ARM_DISARM.

        Args:
            order: The command.
        """
        if order.param1 == 1.0:
            self.armed = True
            return Result.ACCEPTED
        if order.param1 != 0.0:
            return Result.UNSUPPORTED
        if self.airframe.flying:
            # Both refuse while they fly; the one that is forced would stop a real engine.
            return self.disarm_in_flight
        self.armed = False
        return Result.ACCEPTED

    def restart(self) -> None:
        """Boot anew: parameters and clock begin again, the aircraft flies on."""
        self.parameters = OnboardParameters(self.defaults(self._configuration, self.density_factor))
        self.clock_offset = -self.time
        self.failsafe = False
        self.texts.clear()
        self.mode = self.loiter_mode if self.airframe.flying else self.ground_mode
        self.enter(self.mode)

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
    def roll_limit(self) -> float:
        """Steepest bank now in [rad]."""

    @property
    @abstractmethod
    def roll_response(self) -> tuple[float, float]:
        """Time constant in [s] and greatest rate in [rad/s] of the bank."""

    @abstractmethod
    def may_enter(self, mode: str) -> bool:
        """Whether a mode may be entered now; says why where it may not.

        Args:
            mode: Its name.
        """

    @abstractmethod
    def enter(self, mode: str) -> None:
        """Begin to fly a mode.

        Args:
            mode: Its name.
        """

    @abstractmethod
    def watch(self) -> None:
        """Look after the failsafes, once a tick."""

    @abstractmethod
    def fly(self) -> Demand:
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

    def heard_heartbeat(self, system: int, ground_station: bool) -> None:  # noqa: B027
        """Take in the heartbeat of another system; not every autopilot counts all of them.

        Args:
            system: Its MAVLink system.
            ground_station: Whether it says that it is one.
        """
