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

"""What a solver gives back: a status in words, and a plan that is always finite and in the box."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.mpc.problem import OptimalControlProblem


class Status(Enum):
    """How a solve ended; the value is what people read."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit"
    TIME_LIMIT = "time limit"
    INFEASIBLE = "infeasible"
    FAILED = "failed"
    REFUSED = "refused"


@dataclass(frozen=True)
class Solution:
    """Result of one solve.

    Attributes:
        status: How it ended.
        message: The status with its reason, for people.
        cost: V_N at the plan [-], nan if it could not be evaluated.
        iterations: Iterations of the solver.
        solve_time: Wall time in [s].
        states: x_0..x_N, shape (N + 1, nx), as (19).
        inputs: u_0..u_{N-1}, shape (N, nu), as (18): finite and inside the box whatever the status.
        decision: a, shape (na,).
        violation: Largest violation of a hard constraint at the plan, in its own units [-].
    """

    status: Status
    message: str
    cost: float
    iterations: int
    solve_time: float
    states: NDArray[np.float64]
    inputs: NDArray[np.float64]
    decision: NDArray[np.float64]
    violation: float

    @classmethod
    def without_plan(
        cls, problem: OptimalControlProblem, status: Status, reason: str, solve_time: float
    ) -> Solution:
        """What a solve gives back that found nothing: inputs at rest, states 0.

        Args:
            problem: What was to be solved.
            status: How it ended.
            reason: Why, in words.
            solve_time: Wall time in [s].
        """
        return cls(
            status=status,
            message=f"{status.value}: {reason}",
            cost=float("nan"),
            iterations=0,
            solve_time=solve_time,
            states=np.zeros((problem.horizon + 1, problem.nx)),
            inputs=np.tile(problem.input_rest, (problem.horizon, 1)),
            decision=np.array(problem.decision_guess, dtype=float),
            violation=float("inf"),
        )

    @property
    def converged(self) -> bool:
        """Whether the plan is a solution to the stated tolerance."""
        return self.status is Status.CONVERGED
