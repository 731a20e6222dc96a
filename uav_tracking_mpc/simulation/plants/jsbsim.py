"""Six degrees of freedom: JSBSim's equations of motion behind an autopilot's inner loops."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.airframe import RATE, Airframe, AirframeError, Start
from uav_tracking_mpc.simulation.flight_control import FlightControl
from uav_tracking_mpc.simulation.plants import Plant, SimulationError


class JSBSimPlant(Plant):
    """The airframe of :mod:`~uav_tracking_mpc.simulation.airframe`, trimmed where it starts.

    What is measured is what an autopilot's telemetry holds: the heading is the yaw of the body and
    the path angle asin of climb rate over true airspeed, in the mean air; the rates are those of
    yaw and pitch. Lag and dead time are what servos, loops and airframe make of them, not
    parameters.

    Args:
        parameters: Start, limits, air and sensors.

    Attributes:
        airframe: The aircraft.
        control: Its inner loops.

    Raises:
        SimulationError: JSBSim is not installed, or there is no steady flight to start from.
    """

    name = "jsbsim"

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
        turn_rate, pitch_rate = airframe.rates
        # A stamp between two steps: at most half a step from the nearer one.
        ahead = self.time - airframe.steps / RATE
        return Measurement(
            stamp=self.time,
            position=airframe.position + ahead * velocity,
            ground_velocity=velocity,
            heading=airframe.heading,
            path_angle=flown.path_angle,
            turn_rate=turn_rate,
            path_angle_rate=pitch_rate,
            airspeed=flown.airspeed,
        )

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
