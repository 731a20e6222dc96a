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

r"""The vehicle (3) in moving air, behind an autopilot that flies plans and lags, or holds.

The autopilot's inner loop: each rate follows its command after a dead time, with a lag. The turn
rate may follow as a damped oscillation instead, as the roll of many aircraft does.

While rates still approach their commands, heading, path angle and airspeed are sums of
exponentials in closed form; only the position, the integral of
:func:`~uav_tracking_mpc.dynamics.vehicle.air_velocity`, is left to a quadrature, Gauss-Legendre
with five points on panels that are short beside any turn.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.energy_hold import hold
from uav_tracking_mpc.dynamics.frames import turn_rate_from_bank, wrap_angle
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.dynamics.vehicle import advance, air_velocity, followed, velocity
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import AIR, Plant
from uav_tracking_mpc.simulation.wind import Wind

TIME_ROUNDING = 1e-7  # s, rounding by which a command may take effect too early


class Channel:
    """One rate: lag * rate' = wanted - rate, where wanted(t) = command(t - dead_time).

    Args:
        lag: Time constant in [s]; 0 follows at once.
        dead_time: In [s].

    Attributes:
        lag: As above.
        dead_time: As above.
        rate: Flown now, in [rad/s] or [m/s^2].
        wanted: The command that it follows now, in the same unit.
    """

    def __init__(self, lag: float, dead_time: float) -> None:
        self.lag, self.dead_time = lag, dead_time
        self.rate = self.wanted = 0.0
        self._pending: deque[tuple[float, float]] = deque()  # when it becomes wanted, and what

    def command(self, time: float, value: float) -> None:
        """Record a command that takes effect a dead time later.

        Commands recorded for later times are discarded: the clock went back.

        Args:
            time: From which it is commanded in [s].
            value: Rate that is commanded, in its own unit, [rad/s] or [m/s^2].
        """
        due = time + self.dead_time
        self.mature(time)
        while self._pending and self._pending[-1][0] >= due - TIME_ROUNDING:
            self._pending.pop()
        if self.dead_time == 0.0:
            self.wanted = value
        elif value != (self._pending[-1][1] if self._pending else self.wanted):
            self._pending.append((due, value))

    def mature(self, time: float) -> None:
        """Follow the newest command whose dead time is over.

        Args:
            time: Now in [s].
        """
        while self._pending and self._pending[0][0] <= time + TIME_ROUNDING:
            self.wanted = self._pending.popleft()[1]

    @property
    def next_change(self) -> float:
        """When the next recorded command takes effect in [s]; infinite without one."""
        return self._pending[0][0] if self._pending else math.inf

    def rate_after(self, duration: float) -> float:
        """Rate at the end of a time in which ``wanted`` stays, in its own unit; exact.

        Args:
            duration: Of that time in [s].
        """
        if self.lag == 0.0:
            return self.wanted
        return self.rate + (self.wanted - self.rate) * followed(duration, self.lag)

    def integral(self, duration: float) -> float:
        """Integral of the rate over a time in which ``wanted`` stays, in [rad] or [m/s]; exact.

        Args:
            duration: Of that time in [s].
        """
        begun = (self.rate - self.wanted) * self.lag * followed(duration, self.lag)
        return self.wanted * duration + begun

    def follow(self, duration: float) -> None:
        """Move the rate on by a time in which ``wanted`` stays.

        Args:
            duration: Of that time in [s].
        """
        self.rate = self.rate_after(duration)


class OscillatingChannel(Channel):
    """One rate: rate'' + 2 d w rate' + w^2 rate = w^2 wanted, w the frequency, d the damping.

    Args:
        frequency: Natural frequency w in [rad/s].
        damping: Damping ratio d, below 1, [-].
        dead_time: In [s].
    """

    def __init__(self, frequency: float, damping: float, dead_time: float) -> None:
        super().__init__(2.0 * damping / frequency, dead_time)  # the lag that it is alike
        self._frequency, self._decay = frequency, damping * frequency
        self._swing = frequency * math.sqrt(1.0 - damping**2)
        self._slope = 0.0  # rate'

    def _after(self, duration: float) -> tuple[float, float]:
        """What the rate is off what is wanted after a time, and its slope."""
        off, decay, swing = self.rate - self.wanted, self._decay, self._swing
        across = (self._slope + decay * off) / swing
        cos, sin = math.cos(swing * duration), math.sin(swing * duration)
        left = math.exp(-decay * duration)
        after = left * (off * cos + across * sin)
        return after, left * swing * (across * cos - off * sin) - decay * after

    def rate_after(self, duration: float) -> float:
        """See :meth:`Channel.rate_after`."""
        return self.wanted + self._after(duration)[0]

    def integral(self, duration: float) -> float:
        """See :meth:`Channel.integral`."""
        after, slope = self._after(duration)
        lost = slope - self._slope + 2.0 * self._decay * (after - self.rate + self.wanted)
        return self.wanted * duration - lost / self._frequency**2

    def follow(self, duration: float) -> None:
        """See :meth:`Channel.follow`."""
        after, self._slope = self._after(duration)
        self.rate = self.wanted + after


class InnerLoop:
    """The channels of turn rate, path-angle rate and acceleration.

    Args:
        lags: Time constants in [s], three.
        dead_times: In [s], three.
        turn: Of the turn rate, where it does not follow with its lag.

    Attributes:
        channels: The three.
    """

    def __init__(
        self, lags: Sequence[float], dead_times: Sequence[float], turn: Channel | None = None
    ) -> None:
        lagging, climb, gain = (Channel(*each) for each in zip(lags, dead_times, strict=True))
        self.channels = turn or lagging, climb, gain

    def command(self, time: float, inputs: Sequence[float]) -> None:
        """Record inputs that take effect a dead time later.

        Args:
            time: From which they are commanded in [s].
            inputs: (u_psi, u_chi, u_v), shape (3,), in [rad/s], [rad/s] and [m/s^2].
        """
        for channel, value in zip(self.channels, inputs, strict=True):
            channel.command(time, value)

    def unchanged_until(self, time: float) -> float:
        """Follow the commands whose dead time is over.

        Args:
            time: Now in [s].

        Returns:
            When the next command takes effect in [s]; infinite without one.
        """
        for channel in self.channels:
            channel.mature(time)
        return min(channel.next_change for channel in self.channels)


PANEL = 0.05  # s, longest
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)
POINTS = tuple(zip((0.5 * (1.0 + _NODES)).tolist(), (0.5 * _WEIGHTS).tolist(), strict=True))


def advance_lagged(
    state: Sequence[float], channels: tuple[Channel, Channel, Channel], duration: float
) -> tuple[float, float, float, float, float, float]:
    """State after ``duration``, with what each channel wants held.

    Args:
        state: (x, y, z, psi, chi, v), shape (6,), in [m], [rad] and [m/s].
        channels: Of turn rate, path-angle rate and acceleration; their rates are moved on.
        duration: In [s], positive.

    Returns:
        State at the end, shape (6,), angles wrapped to (-pi, pi].
    """
    x, y, z, psi, chi, v = state
    turn, climb, engine = channels
    count = math.ceil(duration / PANEL)
    step = duration / count
    for _ in range(count):
        for point, weight in POINTS:
            moment = point * step
            heading = psi + turn.integral(moment)
            path_angle = chi + climb.integral(moment)
            airspeed = v + engine.integral(moment)
            east, north, up = air_velocity(heading, path_angle, airspeed, math)
            x += weight * step * east
            y += weight * step * north
            z += weight * step * up
        psi, chi, v = (
            start + channel.integral(step)
            for start, channel in zip((psi, chi, v), channels, strict=True)
        )
        for channel in channels:
            channel.follow(step)
    if max(abs(psi), abs(chi)) >= math.pi:  # seldom, and slow
        psi, chi = wrap_angle([psi, chi]).tolist()
    return x, y, z, psi, chi, v


LEVELLING_TIME = 1.0  # s, in which wings-level flight takes the path angle out


class VehiclePlant(Plant):
    """Flies the newest plan, then wings level.

    (3) moves it through the air, and the air moves over ground, which lies at z = 0: the airspeed
    is the autopilot's, so a gust shifts the vehicle and does not shake it.

    Args:
        parameters: Start, limits, inner loop, wind and sensors.

    Attributes:
        state: (x, y, z, psi, chi, v), shape (6,): position in ``map`` in [m]; heading [rad], path
            angle [rad] and magnitude [m/s] of the velocity through the air.
    """

    name = "vehicle"
    changeable = AIR

    def __init__(self, parameters: SimulatorParameters) -> None:
        super().__init__(parameters)
        self.state = parameters.initial_state
        turn: Channel | None = None
        if parameters.roll_frequency:
            roll = parameters.roll_frequency, parameters.roll_damping
            turn = OscillatingChannel(*roll, parameters.dead_time[0])
        self._inner_loop = InnerLoop(parameters.rate_lag, parameters.dead_time, turn)
        gusts, _ = np.random.SeedSequence(parameters.seed).spawn(2)  # the other is the sensors'
        _, _, height = parameters.initial_position
        self._wind = Wind(
            parameters.wind,
            parameters.gust_intensity,
            gusts,
            heading=parameters.initial_heading,
            height=height,
        )

    @property
    def rates(self) -> NDArray[np.float64]:
        """(u_psi, u_chi, u_v) flown now, shape (3,); zero before the first step."""
        return np.array([channel.rate for channel in self._inner_loop.channels])

    @property
    def wind(self) -> NDArray[np.float64]:
        """See :meth:`Plant.wind`."""
        return self._wind.velocity

    @property
    def ground_velocity(self) -> NDArray[np.float64]:
        """Velocity through the air plus that of the air in ``map``, shape (3,), in [m/s]."""
        return velocity(self.state) + self._wind.velocity

    @property
    def truth(self) -> Measurement:
        """See :meth:`Plant.truth`."""
        *position, heading, path_angle, airspeed = self.state.tolist()
        turn, climb, _ = self._inner_loop.channels
        return Measurement(
            stamp=self.time,
            position=np.array(position),
            ground_velocity=self.ground_velocity,
            heading=heading,
            path_angle=path_angle,
            turn_rate=turn.rate,
            path_angle_rate=climb.rate,
            airspeed=airspeed,
        )

    def inputs(self) -> tuple[float, float, float]:
        """(u_psi, u_chi, u_v) that the autopilot commands now: the plan's, or wings level."""
        limits = self.parameters
        *_, path_angle, airspeed = self.state.tolist()
        plan = self.plan.inputs(self.time)
        if plan is None:
            turn, climb, acceleration = 0.0, -path_angle / LEVELLING_TIME, 0.0
        else:
            turn, climb, acceleration = (plan * limits.command_gain).tolist()
        turn_max = turn_rate_from_bank(-limits.bank_max, max(airspeed, 1e-6))
        turn_max = min(turn_max, limits.yaw_rate_max)
        climb_max = limits.pitch_rate_max
        return (
            min(max(turn, -turn_max), turn_max),
            min(max(climb, -climb_max), climb_max),
            min(max(acceleration, limits.acceleration_min), limits.acceleration_max),
        )

    def change(self, parameters: SimulatorParameters) -> None:
        """See :meth:`Plant.change`."""
        super().change(parameters)
        *_, height, heading, _, _ = self.state.tolist()
        self._wind.change(parameters.wind, parameters.gust_intensity, heading, height)

    def advance(self, duration: float) -> None:
        """See :meth:`Plant.advance`."""
        if duration <= 0.0:
            return
        self._inner_loop.command(self.time, self.inputs())
        _, _, height, heading, _, airspeed = self.state.tolist()
        flown = 0.0
        while flown < duration:
            until = min(self._inner_loop.unchanged_until(self.time + flown) - self.time, duration)
            self._fly(until - flown)
            flown = until
        *_, heading_after, _, _ = self.state.tolist()
        self.state[:3] += self._wind.advance(
            duration,
            airspeed=airspeed,
            height=height,
            heading=heading,
            turn=math.remainder(heading_after - heading, 2.0 * math.pi),
        )
        self.time += duration

    def _fly(self, duration: float) -> None:
        """Fly through the air for a time [s] in which the channels' commands stay the same."""
        turn, climb, engine = self._inner_loop.channels
        *_, airspeed = self.state.tolist()
        gained = engine.integral(duration)
        slowest, fastest = self.parameters.speed_min, self.parameters.speed_max
        allowed = min(max(gained, slowest - airspeed), fastest - airspeed)
        acceleration = engine
        if gained != allowed:  # the limit is reached at the end, whatever the engine does
            acceleration = Channel(lag=0.0, dead_time=0.0)
            acceleration.wanted = allowed / duration
        channels = (turn, climb, acceleration)
        if any(channel.lag for channel in channels):
            self.state = np.array(advance_lagged(self.state.tolist(), channels, duration))
        else:
            inputs = [channel.wanted for channel in channels]
            self.state = advance(self.state, inputs, duration)
            for channel in channels:
                channel.rate = channel.wanted
        if acceleration is not engine:
            engine.rate = 0.0


class HeldPlant(VehiclePlant):
    """Flies the turn rate of the newest plan, else wings level, and holds what it is told.

    Commanded path-angle rates and accelerations are ignored. Altitude and airspeed are held by
    :func:`~uav_tracking_mpc.dynamics.energy_hold.hold`, those of the start until an orbit is told;
    the altitude moves on with the centre of the orbit.

    Args:
        parameters: Start, limits, inner loop, constants of the hold, wind and sensors.

    Attributes:
        airspeed: That is held in [m/s].
    """

    name = "held"

    def __init__(self, parameters: SimulatorParameters) -> None:
        super().__init__(parameters)
        _, _, self._height = parameters.initial_position
        self._climb, self._told = 0.0, 0.0  # of the altitude that is held [m/s], and when told [s]
        self.airspeed = parameters.initial_speed

    @property
    def altitude(self) -> float:
        """Altitude in ``map`` that is held now in [m]."""
        return self._height + self._climb * (self.time - self._told)

    def see_orbit(self, orbit: FlownOrbit) -> None:
        """See :meth:`Plant.see_orbit`."""
        self._height, self._climb = float(orbit.centre[2]), float(orbit.velocity[2])
        self._told, self.airspeed = self.time, orbit.airspeed

    def inputs(self) -> tuple[float, float, float]:
        """(u_psi, u_chi, u_v) that the autopilot flies now: the plan's turn, and what holds."""
        turn, _, _ = super().inputs()
        _, _, height, _, path_angle, airspeed = self.state.tolist()
        climb_rate = airspeed * math.sin(path_angle) + float(self.wind[2]) - self._climb
        climb, gain = hold(
            self.altitude - height,
            climb_rate,
            path_angle,
            airspeed,
            self.airspeed - airspeed,
            self.parameters.hold_constants,
            math,
        )
        limits = self.parameters
        return (
            turn,
            min(max(climb, -limits.pitch_rate_max), limits.pitch_rate_max),
            min(max(gain, limits.acceleration_min), limits.acceleration_max),
        )
