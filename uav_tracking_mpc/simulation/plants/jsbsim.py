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

Its sensors tell position, ground velocity and airspeed, and attitude and rates of the body: the
path is found from them by :mod:`~uav_tracking_mpc.estimation.flight_path`. The truth is the motion
of a point mass that does not slip: the heading past the nose, the turn rate of the bank, and with
the path angle :math:`\chi = \arcsin(\dot z / v)`

.. math:: \dot\chi = (a_L \cos\phi - g \cos\chi) / v,

where :math:`a_L` is the specific force upwards in the body.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import course_rates_from_euler, turn_rate_from_bank
from uav_tracking_mpc.estimation.flight_path import past_nose
from uav_tracking_mpc.estimation.measurement import Axis, Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.flight_control import FlightControl
from uav_tracking_mpc.simulation.flight_dynamics import RATE, Airframe, AirframeError, Start
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
        flown = self.airframe.flown
        weight = GRAVITY * math.cos(flown.path_angle)
        past = past_nose(flown.bank, flown.pitch, flown.path_angle)
        return replace(
            self.aboard,
            heading=math.remainder(self.airframe.yaw + past, 2.0 * math.pi),
            path_angle=flown.path_angle,
            turn_rate=turn_rate_from_bank(flown.bank, flown.airspeed),
            path_angle_rate=(flown.lift * math.cos(flown.bank) - weight) / flown.airspeed,
            axis=Axis.AIR_VELOCITY,
        )

    @property
    def aboard(self) -> Measurement:
        """See :meth:`Plant.aboard`."""
        airframe = self.airframe
        flown, velocity = airframe.flown, airframe.ground_velocity
        rates = flown.roll_rate, flown.pitch_rate, flown.yaw_rate
        turn_rate, elevation_rate = course_rates_from_euler(flown.bank, flown.pitch, rates)
        # A stamp between two steps: at most half a step from the nearer one.
        ahead = self.time - airframe.steps / RATE
        return Measurement(
            stamp=self.time,
            position=airframe.position + ahead * velocity,
            ground_velocity=velocity,
            heading=airframe.yaw,
            path_angle=flown.pitch,
            turn_rate=turn_rate,
            path_angle_rate=elevation_rate,
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
