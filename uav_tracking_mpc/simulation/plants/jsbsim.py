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

r"""Six degrees of freedom: JSBSim's equations of motion behind an autopilot's inner loops.

What is measured is the motion of the point mass that the controller plans with, from what an
autopilot knows of an aircraft that does not slip: attitude, climb rate, airspeed and specific
force. The nose is no measure of it, for it points above the path by the angle of attack
:math:`\alpha` and, in a turn, past it, and it swings with the yaw. With the path angle
:math:`\chi = \arcsin(\dot z / v)`, bank :math:`\phi` and pitch :math:`\theta`, positive to the
right and upwards,

.. math::

    \sin\chi &= \sin\theta \cos\alpha - \cos\theta \cos\phi \sin\alpha, &
    \psi &= \psi_{nose} + \operatorname{atan2}(\sin\phi \sin\alpha,
              \cos\theta \cos\alpha + \sin\theta \cos\phi \sin\alpha), \\
    \dot\psi &= -g \tan\phi / v, &
    \dot\chi &= (a_L \cos\phi - g \cos\chi) / v,

where :math:`a_L` is the specific force upwards in the body.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import turn_rate_from_bank
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.flight_control import FlightControl
from uav_tracking_mpc.simulation.flight_dynamics import RATE, Airframe, AirframeError, Flown, Start
from uav_tracking_mpc.simulation.plants import AIR, Plant, SimulationError


class JSBSimPlant(Plant):
    """The airframe of :mod:`~uav_tracking_mpc.simulation.flight_dynamics`, trimmed where it starts.

    Lag and dead time are what servos, inner loops and airframe make of them, not parameters.

    Args:
        parameters: Start, limits, air and sensors.

    Attributes:
        airframe: The aircraft.
        control: Its inner loops.

    Raises:
        SimulationError: There is no steady flight to start from.
        ImportError: JSBSim is not installed.
    """

    name = "jsbsim"
    changeable = AIR

    def __init__(self, parameters: SimulatorParameters) -> None:
        super().__init__(parameters)
        air, _ = np.random.SeedSequence(parameters.seed).spawn(2)  # the other is the sensors'
        start = Start(
            parameters.initial_position,
            parameters.initial_heading,
            parameters.initial_path_angle,
            parameters.initial_speed,
            parameters.wind,
            parameters.gust_intensity,
            int(air.generate_state(1)[0]) % 2**31,
        )
        try:
            self.airframe = Airframe(start)
        except AirframeError as error:
            raise SimulationError(str(error)) from error
        self.control = FlightControl(parameters, self.airframe.trim, self.airframe.flown)

    @property
    def wind(self) -> NDArray[np.float64]:
        """See :meth:`Plant.wind`."""
        return self.airframe.wind

    @property
    def truth(self) -> Measurement:
        """See :meth:`Plant.truth`."""
        airframe = self.airframe
        flown, velocity = airframe.flown, airframe.ground_velocity
        weight = GRAVITY * math.cos(flown.path_angle)
        # A stamp between two steps: at most half a step from the nearer one.
        ahead = self.time - airframe.steps / RATE
        return Measurement(
            stamp=self.time,
            position=airframe.position + ahead * velocity,
            ground_velocity=velocity,
            heading=math.remainder(airframe.yaw + _past_nose(flown), 2.0 * math.pi),
            path_angle=flown.path_angle,
            turn_rate=turn_rate_from_bank(flown.bank, flown.airspeed),
            path_angle_rate=(flown.lift * math.cos(flown.bank) - weight) / flown.airspeed,
            airspeed=flown.airspeed,
            bank=flown.bank,
        )

    def change(self, parameters: SimulatorParameters) -> None:
        """See :meth:`Plant.change`."""
        super().change(parameters)
        self.airframe.blow(parameters.wind, parameters.gust_intensity)

    def advance(self, duration: float) -> None:
        """See :meth:`Plant.advance`."""
        if duration <= 0.0:
            return
        end = self.time + duration
        for _ in range(round(end * RATE) - self.airframe.steps):
            self._step()
        self.time = end

    def _step(self) -> None:
        now = self.airframe.steps / RATE
        plan = self.plan.inputs(now)
        inputs = None if plan is None else (plan * self.parameters.command_gain).tolist()
        surfaces = self.control.surfaces(inputs, self.airframe.flown, 1.0 / RATE)
        try:
            self.airframe.step(surfaces)
        except AirframeError as error:
            raise SimulationError(f"at {now:.4g} s {error}") from error
        if self.airframe.height < 0.0:
            raise SimulationError(f"at {now:.4g} s the aircraft hits the ground")


def _past_nose(flown: Flown) -> float:
    """By how much the velocity through the air points to the left of the nose, in [rad]."""
    sin_pitch, cos_pitch = math.sin(flown.pitch), math.cos(flown.pitch)
    sin_bank, cos_bank = math.sin(flown.bank), math.cos(flown.bank)
    upright = math.hypot(sin_pitch, cos_pitch * cos_bank)
    climb = min(max(math.sin(flown.path_angle) / upright, -1.0), 1.0)
    alpha = math.atan2(sin_pitch, cos_pitch * cos_bank) - math.asin(climb)
    ahead = cos_pitch * math.cos(alpha) + sin_pitch * cos_bank * math.sin(alpha)
    return math.atan2(sin_bank * math.sin(alpha), ahead)
