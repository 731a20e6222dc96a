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

"""The problem solved by a stagewise Newton method, compiled for it on first use.

The method stands in :mod:`uav_tracking_mpc.mpc.newton`; here its data enter and its results leave.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time
from uav_tracking_mpc.mpc.cold_start import ColdStart
from uav_tracking_mpc.mpc.compiled_method import compile_method
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution, Status
from uav_tracking_mpc.mpc.solver import Guess
from uav_tracking_mpc.mpc.stage_code import multiplier_intervals

# In the order of the codes in newton/minimise.py; the last two are ways to fail and to begin.
STATUSES = (*Status, Status.FAILED)
CONVERGED, ITERATION_LIMIT, TIME_LIMIT, INFEASIBLE, STALLED, REFUSED, NO_START = range(7)
WARM = 0  # start code of newton/minimise.py


class NewtonSolver:
    """Solver (see :class:`uav_tracking_mpc.mpc.solver.Solver`) by stagewise exact Newton steps.

    The first solver of a problem compiles the method for it (some ten seconds, logged); the machine
    code is kept in the user's cache directory for every later process.

    Args:
        problem: What to solve.
        tolerance: Of the KKT residual [-]: the gradient of the Lagrangian projected on the input
            box, relative to 1 + its largest component before projection, and the residuals of
            constraints and complementarity in the units of the constraints.
        iteration_limit: Newton iterations from each initial guess.
        time_limit: For a whole solve, in [s].

    Raises:
        ValueError: A tolerance or limit that is not positive.
        NotImplementedError: The problem uses an operation that has no translation.
    """

    @one_at_a_time
    def __init__(
        self,
        problem: OptimalControlProblem,
        tolerance: float = 1e-6,
        iteration_limit: int = 200,
        time_limit: float = math.inf,
    ) -> None:
        for label, value in (
            ("tolerance", tolerance),
            ("iteration_limit", iteration_limit),
            ("time_limit", time_limit),
        ):
            if not value > 0.0:
                raise ValueError(f"{label} is {value}, must be positive")
        self.name = "newton"
        self.problem = problem
        self.tolerance = float(tolerance)
        self.iteration_limit = int(iteration_limit)
        self.time_limit = float(time_limit)
        method = compile_method(problem)
        self._method, self._run = method, method.entry()
        self._workspace = np.zeros(1, method.workspace.WORKSPACE)
        self._address = self._workspace.ctypes.data
        self.change(problem)

    def change(self, problem: OptimalControlProblem) -> None:
        """See :meth:`uav_tracking_mpc.mpc.solver.Solver.change`."""
        self.problem = problem
        self._fill(int(self._method.workspace.KEPT))
        self._cold_start = ColdStart(problem, self._method, self._workspace[0])
        self._warm = False

    def _fill(self, row: int) -> None:
        """Numbers of the problem into the workspace, and views of what every solve touches."""
        problem, record = self.problem, self._workspace[0]
        intervals = multiplier_intervals(problem)  # of h and of e
        for name, values in {
            "u_lower": problem.input_lower,
            "u_upper": problem.input_upper,
            "a_lower": problem.decision_lower,
            "a_upper": problem.decision_upper,
            "a_guess": problem.decision_guess,
            "goal": () if problem.state_goal is None else problem.state_goal,
        }.items():
            record[name][: len(values)] = values
        for kind, (lower, upper) in enumerate(intervals):
            record["m_lower"][kind, : lower.size] = lower
            record["m_upper"][kind, : upper.size] = upper
        self._x_0 = record["x_0"]
        self._p = record["p"][:, : problem.np]
        self._p[:] = problem.usual_parameter
        self._usual = True  # whether p is the problem's own
        self._states = record["x"][row]
        self._inputs = record["u"][row]
        self._decision = record["a"][row][: problem.na]
        self._value = record["value"][row]
        self._outcome = record["outcome"]
        record["horizon"][0], record["ends"][0] = problem.horizon, intervals[1].shape[1]

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""
        self._warm = False

    def solve(
        self,
        initial_state: ArrayLike,
        parameters: ArrayLike | None = None,
        elapsed: float | None = None,
        guess: Callable[[], Guess | None] | None = None,
    ) -> Solution:
        """Solve P_N(x_0), (16): see :meth:`uav_tracking_mpc.mpc.solver.Solver.solve`."""
        begin = time.perf_counter()
        try:
            self._x_0[:] = initial_state
            if parameters is not None or not self._usual:
                self._p[:] = self.problem.usual_parameter if parameters is None else parameters
                self._usual = parameters is None
            warm = self._warm and elapsed is not None
            stages = max(0.0, (elapsed or 0.0) / self.problem.step)  # 0 for nan as well
        except (TypeError, ValueError) as error:
            return self._refused(str(error), begin)
        deadline = begin + self.time_limit
        code = iterations = 0
        if warm:
            code = self._run(
                self._address, WARM, stages, self.tolerance, self.iteration_limit, deadline
            )
            iterations = int(self._outcome[0])
        if not warm or code not in (CONVERGED, TIME_LIMIT, REFUSED):
            code, count = self._cold(deadline, guess)
            iterations += count
        if code == REFUSED:
            return self._refused("initial state or a parameter is not finite", begin)
        # A plan that ran out of time obeys the dynamics and is worth going on from; any other
        # that has not converged is not.
        self._warm = code in (CONVERGED, TIME_LIMIT)
        _, cost, violation = self._value.tolist()
        return Solution(
            STATUSES[code],
            "converged" if code == CONVERGED else self._reason(code),
            cost,
            iterations,
            time.perf_counter() - begin,
            self._states.copy(),
            self._inputs.copy(),
            self._decision.copy(),
            violation,
        )

    def _cold(self, deadline: float, guess: Callable[[], Guess | None] | None) -> tuple[int, int]:
        def attempt(start: int, tolerance: float, limit: int) -> int:
            return self._run(self._address, start, 0.0, tolerance, limit, deadline)

        # Before anything of the last plan is overwritten.
        if not (np.isfinite(self._x_0).all() and np.isfinite(self._p).all()):
            return REFUSED, 0
        begin = guess() if guess is not None else None
        return self._cold_start(attempt, self.tolerance, self.iteration_limit, begin)

    def _reason(self, code: int) -> str:
        gradient, violation = self._outcome[1], self._value[2]
        if code == ITERATION_LIMIT:
            return f"iteration limit {self.iteration_limit} reached, gradient {gradient:.3g}"
        if code == TIME_LIMIT:
            return f"time limit {self.time_limit} s reached, gradient {gradient:.3g}"
        if code == INFEASIBLE:
            return f"infeasible: hard constraints violated by {violation:.3g} at the best plan"
        if code == STALLED:
            return f"failed: no step lowers the cost, gradient {gradient:.3g}"
        return "failed: the dynamics are not finite from this state under any initial guess"

    def _refused(self, reason: str, begin: float) -> Solution:
        elapsed = time.perf_counter() - begin
        return Solution.without_plan(self.problem, Status.REFUSED, reason, elapsed)
