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

"""Add a limit: a cylinder that is fixed to the ground and must not be flown into.

The limit is this one class: its parameters, and one inequality for stages and one for orbits. The
optimiser bends every plan round the cylinder, orbits that would cut it are left, and flown states
inside it are counted as violations::

    uav_tracking simulate --config small_uav --limit examples/add_a_limit.py:NoFlyCylinder
"""

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc import Limit, load_configuration, simulate
from uav_tracking_mpc.limits import Bound, Cylinder, Motion, OrbitShape
from uav_tracking_mpc.parameters.specification import parameter

SCALE = 10.0  # m inside the cylinder are as bad as 1 m/s of airspeed beyond its limit


@dataclass(frozen=True)
class NoFlyCylinder(Limit):
    r"""Keeps out of an upright cylinder: :math:`(x - c_x)^2 + (y - c_y)^2 \ge R^2`."""

    name = "no_fly_cylinder"
    on_ground = True  # seen from a target that moves, the cylinder moves

    cylinder_centre: tuple[float, ...] = parameter(
        (430.0, 10.0), "Its axis in map.", "m", -1e6, 1e6, size=2
    )
    cylinder_radius: float = parameter(60.0, "Its radius.", "m", 1.0, 1e5)

    @property
    def shapes(self) -> tuple[Cylinder, ...]:
        """Where it stands, so that the live page draws it."""
        return (Cylinder(*self.cylinder_centre, self.cylinder_radius, outside=True),)

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """Axis seen from the target (x, y) and radius in [m], shape (n, 3)."""
        axis = np.array(self.cylinder_centre) - targets[:, :2]
        return np.column_stack([axis, np.full(len(targets), self.cylinder_radius)])

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        away = xp.sqrt((motion.x - numbers[0]) ** 2 + (motion.y - numbers[1]) ** 2 + 1e-4)
        return Bound(away, lower=numbers[2], scale=SCALE)

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        gap = xp.sqrt(numbers[0] ** 2 + numbers[1] ** 2) - shape.radius
        return Bound(xp.sqrt(gap**2 + 1e-4), lower=numbers[2], scale=SCALE)


def nearest_to_axis(*overrides: str) -> float:
    """Fly for a minute; returns the least distance to the cylinder's axis in [m]."""
    settings = ["mission.duration=60.0", *overrides]
    log = simulate(load_configuration("small_uav", settings))
    return float(np.hypot(*(log.vehicle[:, :2] - NoFlyCylinder().cylinder_centre).T).min())


if __name__ == "__main__":
    print(f"without the limit: {nearest_to_axis():6.1f} m from the axis")
    bent = nearest_to_axis(f"nmpc_controller.limits={__file__}:NoFlyCylinder")
    print(f"with the limit:    {bent:6.1f} m from the axis, whose cylinder has 60 m")
