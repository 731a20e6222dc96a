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

"""KKT residual of a plan, evaluated by CasADi alone from the problem's expressions."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.mpc.optimality import OptimalityMeasure
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution


def kkt_residual(
    problem: OptimalControlProblem, solution: Solution, x_0: np.ndarray, p: np.ndarray | None = None
) -> float:
    """Smallest stationarity residual over all multipliers that the active constraints allow."""
    return OptimalityMeasure(problem)(x_0, solution.inputs, solution.decision, p)[1]
