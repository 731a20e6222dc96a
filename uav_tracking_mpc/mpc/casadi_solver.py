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

"""The problem as a nonlinear program, handed to fatrop or IPOPT through CasADi."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time
from uav_tracking_mpc.mpc.nonlinear_program import NonlinearProgram
from uav_tracking_mpc.mpc.plan_guesses import plan_guesses
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution, Status
from uav_tracking_mpc.mpc.solver import Guess

PLUGINS = ("ipopt", "fatrop")
FEASIBILITY_TOLERANCE = 1e-5
LONGEST = 1e9  # s, of a solve without a budget: IPOPT has no infinite one
# From the last plan moved on, IPOPT begins with a small barrier and close to the bounds: a fifth of
# the iterations.
WARM = {
    "mu_strategy": "monotone",
    "mu_init": 1e-4,
    **dict.fromkeys(("bound_push", "bound_frac", "slack_bound_push", "slack_bound_frac"), 1e-6),
}
DERIVATIVES = {"grad_f": "nlp_grad_f", "jac_g": "nlp_jac_g", "hess_lag": "nlp_hess_l"}


class CasadiSolver:
    """Solver (see :class:`uav_tracking_mpc.mpc.solver.Solver`) on a CasADi plugin.

    Args:
        problem: What to solve.
        plugin: ``ipopt`` or ``fatrop``. fatrop is four times as fast, but has been seen never to
            return where the model has no value (a state outside its domain): not for flight.
        tolerance: Of the plugin's scaled optimality conditions [-].
        iteration_limit: Per attempt; a solve makes up to two.
        time_limit: Wall time per solve in [s], IPOPT only, which looks at it once an iteration.

    Raises:
        ValueError: Unknown plugin, or a time limit that is not positive.
    """

    @one_at_a_time
    def __init__(
        self,
        problem: OptimalControlProblem,
        plugin: str = "ipopt",
        tolerance: float = 1e-8,
        iteration_limit: int = 200,
        time_limit: float = math.inf,
    ) -> None:
        if plugin not in PLUGINS:
            raise ValueError(f"plugin is {plugin!r}, must be one of {', '.join(PLUGINS)}")
        self.name = plugin
        self.problem = problem
        self._tolerance = tolerance
        self._iteration_limit = iteration_limit
        self._program = NonlinearProgram(problem)
        self._last: Solution | None = None
        self._time_limit: float | None = None
        self.time_limit = time_limit

    @property
    def time_limit(self) -> float:
        """Wall time of one solve in [s]; inf for none."""
        assert self._time_limit is not None
        return self._time_limit

    @time_limit.setter
    def time_limit(self, limit: float) -> None:
        """Set it; IPOPT takes a moment to be built anew.

        Args:
            limit: In [s], positive.
        """
        if limit == self._time_limit:
            return
        if not limit > 0.0:
            raise ValueError(f"time_limit is {limit}, must be positive")
        self._time_limit = limit
        # IPOPT reads its options once: with another budget it is another solver.
        options = self._options(self.name, self._tolerance, min(limit, LONGEST))
        self._cold = self._warm = ca.nlpsol("tracking", self.name, self._program.nlp, options)
        if self.name == "ipopt":
            options["ipopt"].update(WARM)
            for option, function in DERIVATIVES.items():  # they take longer to make than the rest
                options[option] = self._cold.get_function(function)
            self._warm = ca.nlpsol("tracking", self.name, self._program.nlp, options)

    def _options(self, plugin: str, tolerance: float, time_limit: float) -> dict[str, Any]:
        options: dict[str, Any] = {"print_time": False, "expand": True, "error_on_fail": False}
        options["show_eval_warnings"] = False
        if plugin == "ipopt":
            options["ipopt"] = {
                "print_level": 0,
                "sb": "yes",
                "tol": tolerance,
                "max_iter": self._iteration_limit,
                "mu_strategy": "adaptive",
                "max_wall_time": time_limit / 2.0,  # a solve makes up to two attempts
            }
            return options
        structure = self._program
        options.update(
            structure_detection="manual",
            N=self.problem.horizon,
            nx=structure.nx,
            nu=structure.nu,
            ng=structure.ng,
            equality=structure.equality,
            fatrop={"print_level": 0, "tol": tolerance, "max_iter": self._iteration_limit},
        )
        return options

    def change(self, problem: OptimalControlProblem) -> None:
        """See :meth:`uav_tracking_mpc.mpc.solver.Solver.change`."""
        self.problem = problem
        self._program.bound(problem)
        self.reset()

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""
        self._last = None

    def solve(
        self,
        initial_state: ArrayLike,
        parameters: ArrayLike | None = None,
        elapsed: float | None = None,
        guess: Callable[[], Guess | None] | None = None,
    ) -> Solution:
        """Solve P_N(x_0), (16): see :meth:`uav_tracking_mpc.mpc.solver.Solver.solve`."""
        begin = time.perf_counter()
        problem = self.problem
        try:
            x_0 = np.asarray(initial_state, dtype=float).reshape(problem.nx)
            p = np.zeros((problem.horizon + 1, problem.np))
            p[:] = problem.usual_parameter if parameters is None else np.asarray(parameters, float)
        except (TypeError, ValueError) as error:
            return self._unsolved(Status.REFUSED, str(error), begin)
        if not (np.all(np.isfinite(x_0)) and np.all(np.isfinite(p))):
            message = f"initial state {x_0} or a parameter is not finite"
            return self._unsolved(Status.REFUSED, message, begin)
        warm = elapsed is not None and self._last is not None
        solutions: list[Solution] = []
        for last in (self._last, None) if warm else (None,):
            self._nlpsol = self._cold if last is None else self._warm
            guesses = plan_guesses(
                problem,
                x_0,
                last,
                elapsed,
                guess,
                lambda inputs, decision: self._program.rollout(x_0, inputs, p, decision),
            )
            for start in guesses[: 2 - len(solutions)]:
                solutions.append(self._solve_from(*start, x_0, p, begin))
            if solutions[-1].status in (Status.CONVERGED, Status.TIME_LIMIT):
                break
        solution = min(solutions, key=lambda s: (not s.converged, s.violation > 1e-6, s.cost))
        self._last = solution if solution.converged else None
        return solution

    def _solve_from(
        self,
        states: NDArray[np.float64],
        inputs: NDArray[np.float64],
        decision: NDArray[np.float64],
        x_0: NDArray[np.float64],
        p: NDArray[np.float64],
        begin: float,
    ) -> Solution:
        problem, program = self.problem, self._program
        answer = self._nlpsol(
            x0=program.pack(states, inputs, decision),
            p=np.concatenate([x_0, p.ravel()]),
            lbx=program.lower,
            ubx=program.upper,
            lbg=program.constraint_lower,
            ubg=0.0,
        )
        statistics = self._nlpsol.stats()
        variables = np.array(answer["x"]).ravel()
        if not np.all(np.isfinite(variables)):
            message = f"{self.name} returned values that are not finite"
            return self._unsolved(Status.FAILED, message, begin)
        states, inputs, decision = program.unpack(variables)
        constraints = np.array(answer["g"]).ravel()
        violation = float(
            np.max(np.maximum(constraints, np.where(program.equality, -constraints, 0.0)))
        )
        status, message = self._verdict(statistics, violation)
        return Solution(
            status=status,
            message=message,
            cost=float(answer["f"]),
            iterations=int(statistics["iter_count"]),
            solve_time=time.perf_counter() - begin,
            states=states,
            inputs=np.clip(inputs, problem.input_lower, problem.input_upper),
            decision=decision,
            violation=violation,
        )

    def _verdict(self, statistics: dict[str, Any], violation: float) -> tuple[Status, str]:
        reason = str(statistics["return_status"])
        if statistics["success"]:
            return Status.CONVERGED, Status.CONVERGED.value
        if reason == "Maximum_WallTime_Exceeded":
            return Status.TIME_LIMIT, f"time limit after {statistics['iter_count']} iterations"
        if violation > FEASIBILITY_TOLERANCE:
            text = f"infeasible: constraints violated by {violation:.3g} where {self.name} stopped"
            return Status.INFEASIBLE, text
        if int(statistics["iter_count"]) >= self._iteration_limit:
            return Status.ITERATION_LIMIT, f"iteration limit {self._iteration_limit} reached"
        return Status.FAILED, f"{self.name} failed: {reason}"

    def _unsolved(self, status: Status, reason: str, begin: float) -> Solution:
        return Solution.without_plan(self.problem, status, reason, time.perf_counter() - begin)
