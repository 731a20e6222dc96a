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

"""Least height above the origin of ``map``."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.limits import Bound, Floor, Limit, Motion, OrbitShape
from uav_tracking_mpc.parameters.specification import parameter

DEEPEST = 1e4  # m below the target, as deep as the problem is told
SCALE = 5.0  # m


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
