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

"""The last plan, as far as it can stand in for one that cannot be had."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.formulation.formulation import Plan


class PlanMemory:
    """Keeps one plan and what is left of it."""

    def __init__(self) -> None:
        self._plan: Plan | None = None
        self._begin = 0.0

    def reset(self) -> None:
        """Forget the plan."""
        self._plan = None

    def keep(self, plan: Plan, begin: float) -> None:
        """Remember a plan in the place of the one before.

        Args:
            plan: That is flown.
            begin: When its first segment begins in [s].
        """
        self._plan, self._begin = plan, begin

    @property
    def orbit(self) -> NDArray[np.float64] | None:
        """Range, altitude and airspeed of the orbit that the plan ends on, shape (3,), or None."""
        return None if self._plan is None else self._plan.orbit

    def remaining(self, time: float, age_max: float) -> tuple[NDArray[np.float64], float] | None:
        """What is left of the plan.

        Args:
            time: From which on in [s].
            age_max: Age at which a plan counts no more in [s].

        Returns:
            Inputs, shape (n, 3), n >= 1, and the length of a segment in [s]; None if there is
            no plan, or nothing left of it.
        """
        age = time - self._begin
        if self._plan is None or not 0.0 <= age <= age_max:
            return None
        inputs = self._plan.inputs[int(age / self._plan.step) :]
        return (inputs, self._plan.step) if len(inputs) else None
