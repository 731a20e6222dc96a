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

"""How far can be flown at all in N steps? Where that is too little, P_N is surely infeasible."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.stability_problem import StabilityProblem


def distance_budget(
    problem: StabilityProblem, state: NDArray[np.float64], level: float
) -> tuple[float, float]:
    """Range to cover to reach X_f, and an upper bound for what can be flown in N steps.

    Each Euler step changes r by at most T_s v, and v is limited by the acceleration from the start
    and by the speeds that X_f holds at the end.

    Args:
        problem: Horizon, step, input bounds, weights.
        state: (r, theta, z, chi, v), shape (5,).
        level: varrho [-].

    Returns:
        (needed, possible), in [m]. needed > possible proves that (16e) is infeasible.
    """
    inverse = np.linalg.inv(problem.ingredients().weight)
    range_extent, _, _, _, speed_extent = np.sqrt(level * np.diag(inverse))
    r, _, _, _, v = state
    needed = abs(float(r) - problem.orbit.range) - float(range_extent)
    k = np.arange(problem.horizon)
    _, _, up = problem.step * problem.input_upper
    _, _, down = -problem.step * problem.input_lower
    last = problem.orbit.speed + float(speed_extent)
    speeds = np.minimum(v + k * up, last + (problem.horizon - k) * down)
    return needed, float(problem.step * np.maximum(speeds, 0.0).sum())
