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

"""The vehicle in moving air behind an autopilot that itself holds altitude and airspeed."""

from __future__ import annotations

import math

from uav_tracking_mpc.dynamics.energy_hold import hold
from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant


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
