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

"""What can be flown in simulation.

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

from abc import ABC, abstractmethod
from dataclasses import asdict
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.parameters.registry import ExtensionError, ExtensionPoint
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.settings.configuration import Configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plan_follower import PlanFollower
from uav_tracking_mpc.simulation.vehicle_sensors import ERRORS, VehicleSensors

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
        for name, value in asdict(parameters).items():
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
