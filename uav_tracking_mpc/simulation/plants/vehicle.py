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

"""The vehicle (3) in moving air, behind an autopilot that flies plans and lags, or holds."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.dynamics.energy_hold import hold
from uav_tracking_mpc.dynamics.frames import turn_rate_from_bank
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.inner_loop import (
    Channel,
    InnerLoop,
    OscillatingChannel,
    advance_lagged,
)
from uav_tracking_mpc.simulation.plants import AIR, Plant
from uav_tracking_mpc.simulation.wind import Wind

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
        return vehicle.velocity(self.state) + self._wind.velocity

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
            self.state = vehicle.advance(self.state, inputs, duration)
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
