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

"""What can be flown in simulation, and what its sensors make of it.

===============  ==========================================================================
``vehicle``      the vehicle (3) in moving air, behind an autopilot that lags, or that
                 itself holds altitude and airspeed
``jsbsim``       six degrees of freedom with servos and inner loops, by JSBSim
``euler``        the prediction model itself by Euler's method, as in Section 6
``conformance``  whether a plant keeps what the base asks for
===============  ==========================================================================

A plant is a subclass of :class:`Plant` with a name. It is found by that name, by an entry point in
the group ``uav_tracking_mpc.simulation.plants``, or as ``path.py:Class``.
"""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections import deque
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement, SensorNoise
from uav_tracking_mpc.parameters.registry import ExtensionError, ExtensionPoint
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plan_follower import PlanFollower

# Parameters that may change while it measures.
ERRORS = (
    *("position_noise", "velocity_noise", "attitude_noise", "airspeed_noise"),
    *("velocity_bias", "heading_bias", "airspeed_bias", "turn_rate_bias", "position_bias"),
    *("airspeed_fault", "position_fault", "heading_fault", "velocity_fault", "velocity_gain"),
)
TIME_ROUNDING = 1e-9  # s, rounding by which a measurement may be too young


class VehicleSensors:
    """Adds noise and biases, and holds back; without any of them the truth is measured.

    They tell how noisy they are as far as ``uav/odometry`` carries it, which knows no airspeed, and
    keep quiet about biases, as real ones do.

    Args:
        parameters: Standard deviations, biases and delay.
        seed: Of the noise.
    """

    def __init__(self, parameters: SimulatorParameters, seed: np.random.SeedSequence) -> None:
        self._held: deque[Measurement] = deque()
        self._kept: dict[str, Any] = {}  # readings at which sensors are stuck, by their names
        self._random = np.random.default_rng(seed)
        self.change(parameters)

    def change(self, parameters: SimulatorParameters) -> None:
        """Measure with other noise and biases from now on; what is held back stays as it is.

        Args:
            parameters: Standard deviations, biases and delay.
        """
        attitude, airspeed = parameters.attitude_noise, parameters.airspeed_noise
        places, velocities = [parameters.position_noise] * 3, [parameters.velocity_noise] * 3
        self._deviations = np.array([*places, attitude, attitude, airspeed, *velocities])
        heading, airspeed = parameters.heading_bias, parameters.airspeed_bias
        self._biases = np.array(
            [*parameters.position_bias, heading, 0.0, airspeed, *parameters.velocity_bias]
        )
        self._parameters, self._told = parameters, _told(parameters)
        faults = {name: getattr(parameters, f"{name}_fault") for name in FAILING}
        self._kept = {name: kept for name, kept in self._kept.items() if faults[name] in KEEPING}
        errors = *self._deviations, *self._biases, parameters.turn_rate_bias
        faulty = any(fault != "none" for fault in faults.values())
        self._wrong = any(errors) or faulty or parameters.velocity_gain != 1.0

    def measure(self, truth: Measurement) -> Measurement:
        """What is measured; every call draws anew.

        Args:
            truth: State of the aircraft, not older than the one before.

        Returns:
            The newest measurement that is as old as the delay; until there is one, the first.
        """
        measured = self._mistaken(truth) if self._wrong else truth
        delay = self._parameters.state_delay
        if delay == 0.0:
            return measured
        self._held.append(measured)
        latest = truth.stamp - delay + TIME_ROUNDING
        while len(self._held) > 1 and self._held[1].stamp <= latest:
            self._held.popleft()
        late, true = self._held[0], self._parameters.state_stamp_true
        return late if true else dataclasses.replace(late, stamp=truth.stamp)

    def _mistaken(self, truth: Measurement) -> Measurement:
        errors = self._biases.copy()
        if self._deviations.any():
            errors += self._deviations * self._random.standard_normal(len(errors))
        position, attitude, ground_velocity = errors.reshape(3, 3)
        heading, path_angle, airspeed = attitude.tolist()
        right_angle, known = 0.5 * math.pi, self._parameters
        silent = known.position_fault == "silent"
        place = np.full(3, math.nan) if silent else truth.position + position
        kept = self._stuck("position", place)
        if known.position_fault == "level":
            kept = np.append(place[:2], kept[2])
        velocity = known.velocity_gain * truth.ground_velocity + ground_velocity
        return dataclasses.replace(
            truth,
            position=kept,
            ground_velocity=self._stuck("velocity", velocity),
            heading=self._stuck("heading", float(wrap_angle(truth.heading + heading))),
            path_angle=min(max(truth.path_angle + path_angle, -right_angle), right_angle),
            turn_rate=truth.turn_rate + known.turn_rate_bias,
            airspeed=self._airspeed(truth, airspeed),
            noise=self._told,
        )

    def _stuck(self, name: str, reading: Any) -> Any:
        """The reading, or that at which the sensor got stuck."""
        failing = getattr(self._parameters, f"{name}_fault") in KEEPING
        return self._kept.setdefault(name, reading) if failing else reading

    def _airspeed(self, truth: Measurement, error: float) -> float | None:
        """Reading of the airspeed sensor, as its fault lets it through."""
        fault = self._parameters.airspeed_fault
        if truth.airspeed is None or fault == "silent":
            return None
        height = float(truth.position[2])
        airspeed, sealed = self._stuck("airspeed", (max(truth.airspeed + error, 0.0), height))
        if fault != "blocked":
            return float(airspeed)
        # The static pressure falls by rho g per metre, that in the blocked tube does not.
        return math.sqrt(max(airspeed**2 + 2.0 * GRAVITY * (height - sealed), 0.0))


def _told(parameters: SimulatorParameters) -> SensorNoise:
    """Noise as the sensors tell it; what is beyond all measure is not told."""
    attitude = parameters.attitude_noise**2
    axes = [parameters.position_noise**2] * 3, [parameters.velocity_noise**2] * 3
    return SensorNoise.told(*axes, attitude, attitude)


FAILING = ("airspeed", "position", "heading", "velocity")
# Faults by which a sensor keeps what it measured last
KEEPING = ("stuck", "frozen", "level", "blocked")
PACE = ("speed", "command_delay")  # of the parameters, what is not about the plant
AIR = ("wind", "gust_intensity")  # of the parameters, what a plant makes its air of


class SimulationError(RuntimeError):
    """The flight left what the plant can describe; the message says where."""


class Plant(ABC):
    """An aircraft with its autopilot: commands in, time goes on, sensors and the truth out.

    Args:
        parameters: Start, limits, air and sensors; a plant may leave some of them aside.

    Attributes:
        name: By which it is found.
        period: Time in [s] from one command to the next, where the plant has one of its own.
        changeable: Names of the parameters that :meth:`change` takes, beside those of the sensors.
        parameters: As above.
        time: Of the state in [s], since the start.
        plan: What it was told to fly, and how often it had nothing left to fly.
    """

    name: ClassVar[str]
    period: float | None = None
    changeable: ClassVar[tuple[str, ...]] = ()

    def __init__(self, parameters: SimulatorParameters) -> None:
        self.parameters = parameters
        self.time = 0.0
        self.plan = PlanFollower(parameters.command_delay)
        _, noise = np.random.SeedSequence(parameters.seed).spawn(2)  # the first is the air's
        self._sensors = VehicleSensors(parameters, noise)

    @classmethod
    def of(cls, configuration: Configuration) -> Plant:
        """The plant of a mission.

        Args:
            configuration: Of the mission; a plant that depends on more than the simulator's
                parameters takes it from here.
        """
        return cls(configuration.simulator)

    def accept(self, inputs: ArrayLike, starts: ArrayLike) -> None:
        """Take over a plan; see :meth:`PlanFollower.accept`.

        Args:
            inputs: (u_psi, u_chi, u_v) of each segment, shape (n, 3), in [rad/s], [rad/s] and
                [m/s^2].
            starts: When each begins in [s], shape (n,).

        Raises:
            ValueError: The plan cannot be flown; the present one stays.
        """
        self.plan.accept(inputs, starts, self.time)

    def see_orbit(self, orbit: FlownOrbit) -> None:
        """Take over the orbit that is flown; an autopilot that holds nothing itself needs none.

        Args:
            orbit: At the present time.
        """
        return

    def check(self, parameters: SimulatorParameters) -> None:
        """Whether other parameters can be taken in flight.

        Args:
            parameters: All of them.

        Raises:
            ParameterError: One differs that is fixed, or that this plant cannot change.
        """
        refuse_fixed(self.parameters, parameters, "while the simulator runs")
        for name, value in dataclasses.asdict(parameters).items():
            before = getattr(self.parameters, name)
            if value != before and name not in (*ERRORS, *PACE, *self.changeable):
                raise ParameterError(
                    f"parameter '{name}' is {value!r}, must stay {before!r}: the plant "
                    f"'{self.name}' cannot change it in flight"
                )

    def change(self, parameters: SimulatorParameters) -> None:
        """Fly on with other air and other sensors; state and plan stay.

        A plant that overrides this names in ``changeable`` what it takes besides, and calls this
        one first.

        Args:
            parameters: All of them.

        Raises:
            ParameterError: As of :meth:`check`; nothing has changed.
        """
        self.check(parameters)
        self.parameters = parameters
        self.plan.delay = parameters.command_delay
        self._sensors.change(parameters)

    @abstractmethod
    def advance(self, duration: float) -> None:
        """Fly on.

        Args:
            duration: How long in [s]; nothing happens unless it is positive.

        Raises:
            SimulationError: The flight left what the plant can describe.
        """

    @property
    @abstractmethod
    def truth(self) -> Measurement:
        """The state now: position and velocity through the air."""

    @property
    def aboard(self) -> Measurement:
        """The state now as ideal sensors aboard give it: the truth, unless the body says less."""
        return self.truth

    @property
    def wind(self) -> NDArray[np.float64]:
        """Velocity of the air now with its gusts in ``map``, shape (3,), in [m/s]."""
        return np.zeros(3)

    def measured(self) -> Measurement:
        """The state now, as the sensors give it; every call draws their noise anew."""
        return self._sensors.measure(self.aboard)


PLANT = ExtensionPoint("plant", Plant)


def plant_named(name: str) -> type[Plant]:
    """Class of a plant.

    Args:
        name: Of one that is installed, or ``path.py:Class``.

    Raises:
        ParameterError: There is no such plant.
    """
    try:
        return PLANT.find(name)
    except ExtensionError as error:
        raise ParameterError(f"parameter 'plant': {error}") from error


def plant_of(configuration: Configuration) -> Plant:
    """The plant that a mission names.

    Args:
        configuration: Of the mission.

    Raises:
        ParameterError: There is no plant of that name.
        SimulationError: The plant cannot fly the mission.
    """
    return plant_named(configuration.mission.plant).of(configuration)
