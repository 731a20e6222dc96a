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

"""The lagged vehicle whose autopilot itself holds altitude and airspeed: its bank alone is free.

Path-angle rate and acceleration are those of :func:`~uav_tracking_mpc.dynamics.energy_hold.hold`,
towards the altitude and the airspeed that the autopilot is told, and lag like commanded ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.energy_hold import HoldConstants, HoldParameters, hold
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged


@dataclass(frozen=True)
class Held(HoldParameters, Lagged):
    """First-order lag of a turn rate that is commanded and of two rates that hold what is told."""

    name = "held"
    commanded: ClassVar[int] = 1

    def numbers(self, duration: float) -> NDArray[np.float64]:
        """See :meth:`VehicleModel.numbers`.

        Returns:
            Those of :meth:`Lagged.numbers`, then the constants of the autopilot, shape (15,).
        """
        return np.concatenate([super().numbers(duration), self.hold_constants])

    def held(self, state: Any, altitude: Any, airspeed: Any, numbers: Any, drift: Any) -> list[Any]:
        """See :meth:`VehicleModel.held`."""
        xp = ca if isinstance(state.heading, ca.SX) else np
        climb_rate = state.airspeed * xp.sin(state.path_angle) + drift[2]
        constants = HoldConstants(*(numbers[k] for k in range(9, 15)))
        u_chi, u_v = hold(
            altitude - state.z,
            climb_rate,
            state.path_angle,
            state.airspeed,
            airspeed - state.airspeed,
            constants,
            xp,
        )
        return [u_chi, u_v]
