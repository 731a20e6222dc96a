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

"""Limits of where the aircraft may be: height, distance to the target, and a fence."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.limits import Ball, Bound, Cylinder, Floor, Limit, Motion, OrbitShape
from uav_tracking_mpc.parameters.specification import parameter

DEEPEST = 1e4  # m below the target, as deep as the problem is told
SCALE = 5.0  # m, of height that is as bad as 1 m/s of airspeed


@dataclass(frozen=True)
class Height(Limit):
    """height_min <= z in ``map``; the problem sees it from the target."""

    name = "height"
    on_ground = True

    height_min: float = parameter(-1e5, "Least height z in map.", "m", -1e5, 1e5)

    @property
    def shapes(self) -> tuple[Floor, ...]:
        """See :attr:`Limit.shapes`; none where it is deeper than any flight."""
        return (Floor(self.height_min),) if self.height_min > -DEEPEST else ()

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """See :meth:`Limit.numbers`.

        Returns:
            Least height above the target in [m], shape (n, 1).
        """
        return np.maximum(self.height_min - targets[:, 2:], -DEEPEST)

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        return Bound(motion.z, lower=numbers[0], scale=SCALE)

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        return Bound(shape.altitude, lower=numbers[0], scale=SCALE)


SMALL = 0.01  # m, keeps the distance smooth where it vanishes


@dataclass(frozen=True)
class Distance(Limit):
    """distance_min <= r."""

    name = "distance"

    distance_min: float = parameter(0.0, "Least distance to the target.", "m", 0.0, 1e5)

    @property
    def shapes(self) -> tuple[Ball, ...]:
        """See :attr:`Limit.shapes`."""
        return (Ball(self.distance_min),) if self.distance_min > 0.0 else ()

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        r = xp.sqrt(motion.x**2 + motion.y**2 + motion.z**2 + SMALL**2)
        return Bound(r, lower=numbers[0], scale=SCALE)

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        return Bound(shape.range, lower=numbers[0], scale=SCALE)

    def refusal(self, orbit: Orbit, drift: ArrayLike) -> str:
        """See :meth:`Limit.refusal`."""
        if orbit.range >= self.distance_min:
            return ""
        return (
            f"an orbit of {orbit.range:.1f} m range at {orbit.speed:.3g} m/s is nearer to the "
            f"target than the {self.distance_min:.1f} m allowed"
        )


NO_FENCE = 1e6  # m, radius
FENCE_SCALE = 10.0  # m, of distance that is as bad as 1 m/s of airspeed


@dataclass(frozen=True)
class Fence(Limit):
    """Horizontal distance to the fence's centre <= fence_radius."""

    name = "fence"
    on_ground = True

    fence_radius: float = parameter(
        0.0, "Radius of the circle not to be left; 0 for none.", "m", 0.0, 1e6
    )
    fence_centre: tuple[float, ...] = parameter(
        (0.0, 0.0), "Its centre in map.", "m", -1e7, 1e7, size=2
    )

    @property
    def shapes(self) -> tuple[Cylinder, ...]:
        """See :attr:`Limit.shapes`."""
        east, north = self.fence_centre
        fence = Cylinder(east, north, self.fence_radius, outside=False)
        return (fence,) if self.fence_radius > 0.0 else ()

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """See :meth:`Limit.numbers`.

        Returns:
            Centre seen from the target (x, y) and radius in [m], shape (n, 3).
        """
        if self.fence_radius == 0.0:
            numbers = np.zeros((len(targets), 3))
            numbers[:, 2] = NO_FENCE
            return numbers
        centre = np.array(self.fence_centre) - targets[:, :2]
        return np.column_stack([centre, np.full(len(targets), self.fence_radius)])

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        away = _length(motion.x - numbers[0], motion.y - numbers[1], xp)
        return Bound(away, upper=numbers[2], scale=FENCE_SCALE)

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        farthest = _length(numbers[0], numbers[1], xp) + shape.radius
        return Bound(farthest, upper=numbers[2], scale=FENCE_SCALE)


def _length(x: Any, y: Any, xp: ModuleType) -> Any:
    return xp.sqrt(x**2 + y**2 + SMALL**2)
