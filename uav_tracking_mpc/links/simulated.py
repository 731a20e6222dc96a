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

"""A plant behind a link: a user's own loop can be tried on it before anything real flies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import FlownOrbit
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.links import LinkError, VehicleLink
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant, SimulationError, plant_named


class SimulatedLink(VehicleLink):
    """Simulated time goes on by one state period whenever a state is asked for.

    Args:
        address: Name of the plant, or ``path.py:Class``; ``vehicle`` if empty.
        parameters: Of the plant.
    """

    name = "simulated"
    when_silent = "flies the last plan to its end, then holds the wings level"

    def __init__(self, address: str = "", parameters: SimulatorParameters | None = None) -> None:
        super().__init__(address)
        self._parameters = parameters or SimulatorParameters()
        self._flown: Plant | None = None

    @property
    def plant(self) -> Plant:
        """What flies.

        Raises:
            LinkError: It is not connected.
        """
        if self._flown is None:
            raise LinkError("the simulated aircraft is not connected")
        return self._flown

    def connect(self, timeout: float) -> None:
        """See :meth:`VehicleLink.connect`."""
        try:
            self._flown = plant_named(self.address or self._parameters.plant)(self._parameters)
        except (ParameterError, SimulationError) as error:
            raise LinkError(f"there is no such simulated aircraft: {error}") from error

    def close(self) -> None:
        """See :meth:`VehicleLink.close`."""
        self._flown = None

    def now(self) -> float:
        """See :meth:`VehicleLink.now`."""
        return self.plant.time

    def measured(self, timeout: float) -> Measurement | None:
        """See :meth:`VehicleLink.measured`."""
        try:
            self.plant.advance(1.0 / self._parameters.state_rate)
        except SimulationError as error:
            raise LinkError(f"the simulated aircraft is lost: {error}") from error
        return self.plant.measured()

    def command(
        self,
        stamp: float,
        inputs: NDArray[np.float64],
        step: float,
        orbit: FlownOrbit | None = None,
    ) -> str:
        """See :meth:`VehicleLink.command`."""
        try:
            self.plant.accept(inputs, stamp + step * np.arange(len(inputs)))
        except ValueError as error:
            return str(error)
        return ""
