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

"""Least distance to the target."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from numpy.typing import ArrayLike

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.limits import Ball, Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.parameters.specification import parameter

SMALL = 0.01  # [m] keeps the distance smooth where it vanishes
SCALE = 5.0  # m


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
