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

"""The problem as a nonlinear program, solved by a plugin of CasADi."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Guess, Solution, Status, shift, solve_data
from uav_tracking_mpc.symbolic.functions import one_at_a_time


class PlanGuess(NamedTuple):
    """Where a solver begins; states need not obey the dynamics.

    Attributes:
        states: x_0..x_N, shape (N + 1, nx).
        inputs: u_0..u_{N-1}, shape (N, nu).
        decision: a, shape (na,).
    """

    states: NDArray[np.float64]
    inputs: NDArray[np.float64]
    decision: NDArray[np.float64]


def plan_guesses(
    problem: OptimalControlProblem,
    initial_state: NDArray[np.float64],
    last: Solution | None,
    elapsed: float | None,
    make: Callable[[], Guess | None] | None,
    rollout: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]],
) -> list[PlanGuess]:
    """Plans to start from: the last one moved on, or that of the caller, or two cold ones.

    Args:
        problem: What is solved.
        initial_state: x_0, shape (nx,).
        last: The last plan that was one; None for a cold start.
        elapsed: Time in [s] since then; None for a cold start.
        make: Plan of the caller for a cold start.
        rollout: States x_0..x_N, shape (N + 1, nx), under inputs, shape (N, nu), and a decision,
            shape (na,).
    """
    if elapsed is not None and last is not None:
        stages = max(0.0, elapsed) / problem.step
        states = shift(last.states, stages)
        states[0] = initial_state
        return [PlanGuess(states, shift(last.inputs, stages), last.decision)]
    inputs = np.tile(problem.input_rest, (problem.horizon, 1))
    guess = make() if make is not None else None
    if guess is not None:
        inputs[: len(guess.inputs)] = guess.inputs
        decision = np.asarray(guess.decision)
        return [PlanGuess(rollout(inputs, decision), inputs, decision)]
    goal = np.zeros(problem.nx) if problem.state_goal is None else problem.state_goal
    later = (problem.horizon, 1)
    return [
        PlanGuess(np.vstack([initial_state, np.tile(rest, later)]), inputs, problem.decision_guess)
        for rest in (goal, initial_state)
    ]


class NonlinearProgram:
    """Variables, bounds and constraints of the nonlinear program, stage by stage.

    Args:
        problem: What is solved.

    Attributes:
        nlp: The program as CasADi's ``nlpsol`` takes it.
        lower: Least values of the variables.
        upper: Greatest values of the variables.
        constraint_lower: Least values of the constraints; the greatest are 0.
        equality: Which constraints are equalities.
    """

    def __init__(self, problem: OptimalControlProblem) -> None:
        self.problem = problem
        x, u, p, a = problem.state, problem.inputs, problem.parameter, problem.decision
        n, nx, nu, na = problem.horizon, problem.nx, problem.nu, problem.na
        stage_hard, stage_soft, stage_penalty = hard_and_soft(problem.stage_inequalities)
        end_hard, end_soft, end_penalty = hard_and_soft(problem.terminal_inequalities)
        soft = stage_soft.numel()
        stage = ca.Function(
            "stage", [x, u, p, a], [problem.next_state, problem.stage_cost, stage_hard, stage_soft]
        )
        end = ca.Function(
            "end", [x, p, a], [problem.terminal_cost, problem.terminal_equality, end_hard, end_soft]
        )
        initial = ca.SX.sym("initial", nx)
        values = ca.SX.sym("p", problem.np, n + 1)

        variables: list[ca.SX] = []
        constraints, equality = [], []
        cost = ca.SX(0)
        xs = [ca.SX.sym(f"x{i}", nx) for i in range(n + 1)]
        decisions = [ca.SX.sym(f"a{i}", na) for i in range(n + 1)]

        def constrain(expression: ca.SX, is_equality: bool) -> None:
            constraints.append(expression)
            equality.extend([is_equality] * expression.numel())

        for i in range(n):
            ui, si = ca.SX.sym(f"u{i}", nu), ca.SX.sym(f"s{i}", soft)
            variables += [xs[i], decisions[i], ui, si]
            following, stage_cost, hard, soft_value = stage(xs[i], ui, values[:, i], decisions[i])
            cost += stage_cost + ca.dot(stage_penalty, si)
            constrain(xs[i + 1] - following, True)  # (16b)
            constrain(decisions[i + 1] - decisions[i], True)
            if i == 0:
                constrain(xs[0] - initial, True)
            constrain(ca.vertcat(hard, soft_value - si), False)
        s_end = ca.SX.sym("s_end", end_soft.numel())
        variables += [xs[n], decisions[n], s_end]
        end_cost, end_equal, hard, soft_value = end(xs[n], values[:, n], decisions[n])
        cost += end_cost + ca.dot(end_penalty, s_end)
        constrain(end_equal, True)
        constrain(ca.vertcat(hard, soft_value - s_end), False)  # (16e)

        self._stage = stage
        self.equality = equality
        self.constraint_lower = np.where(equality, 0.0, -np.inf)
        self.nlp = {
            "x": ca.vertcat(*variables),
            "f": cost,
            "g": ca.vertcat(*constraints),
            "p": ca.vertcat(initial, ca.vec(values)),
        }
        # Where states, decisions of every stage, and inputs stand among the variables.
        place = np.arange(self.nlp["x"].numel())
        stages = place[: n * (nx + na + nu + soft)].reshape(n, -1)
        whole = np.vstack([stages[:, : nx + na], place[stages.size :][: nx + na]])
        self._x, self._a, self._u = whole[:, :nx], whole[:, nx:], stages[:, nx + na :][:, :nu]
        self.bound(problem)

    def bound(self, problem: OptimalControlProblem) -> None:
        """Take the bounds of the variables from a problem.

        Args:
            problem: Of the same expressions.
        """
        size = self.nlp["x"].numel()
        self.lower, self.upper = np.zeros(size), np.full(size, np.inf)  # of slacks
        self.lower[self._x] = -np.inf
        self.lower[self._u], self.upper[self._u] = problem.input_lower, problem.input_upper
        self.lower[self._a], self.upper[self._a] = problem.decision_lower, problem.decision_upper

    def rollout(
        self,
        x_0: NDArray[np.float64],
        inputs: NDArray[np.float64],
        p: NDArray[np.float64],
        decision: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """States under given inputs; x_0 throughout where they are not finite.

        Args:
            x_0: State of stage 0, shape (nx,).
            inputs: u_0..u_{N-1}, shape (N, nu).
            p: Parameters of stages 0..N, shape (N + 1, np).
            decision: a, shape (na,).

        Returns:
            x_0..x_N, shape (N + 1, nx).
        """
        states = [x_0]
        for u, parameter in zip(inputs, p, strict=False):
            following = self._stage(states[-1], u, parameter, decision)[0]
            states.append(np.array(following).ravel())
        rolled = np.array(states)
        return rolled if np.isfinite(rolled).all() else np.tile(x_0, (len(states), 1))

    def pack(
        self,
        states: NDArray[np.float64],
        inputs: NDArray[np.float64],
        decision: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Variables of the program from a plan; slacks start at 0.

        Args:
            states: x_0..x_N, shape (N + 1, nx).
            inputs: u_0..u_{N-1}, shape (N, nu).
            decision: a, shape (na,).

        Returns:
            All variables, shape (n,).
        """
        variables = np.zeros(len(self.lower))
        variables[self._x], variables[self._a], variables[self._u] = states, decision, inputs
        return variables

    def unpack(
        self, variables: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Plan (states, inputs, decision) from the variables of the program.

        Args:
            variables: Of all stages, shape (n,).

        Returns:
            x_0..x_N, shape (N + 1, nx); u_0..u_{N-1}, shape (N, nu); and a, shape (na,).
        """
        return variables[self._x], variables[self._u], variables[self._a[0]]


def hard_and_soft(inequalities: tuple[Inequality, ...]) -> tuple[ca.SX, ca.SX, ca.DM]:
    """Hard expressions, soft expressions, and the penalty of each row of the soft ones.

    Args:
        inequalities: At a stage, or at the end.
    """
    hard = ca.vertcat(ca.SX.zeros(0, 1), *(h.expression for h in inequalities if h.penalty is None))
    soft = [h for h in inequalities if h.penalty is not None]
    expressions = ca.vertcat(ca.SX.zeros(0, 1), *(h.expression for h in soft))
    penalties = [h.penalty for h in soft for _ in range(h.expression.numel())]
    return hard, expressions, ca.DM(np.array(penalties, dtype=float).reshape(-1, 1))


OPTIONS: dict[str, Any] = {
    "print_time": False,
    "expand": True,
    "error_on_fail": False,
    "show_eval_warnings": False,
}
FEASIBILITY_TOLERANCE = 1e-5  # -, tolerance of the scaled constraints
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
    """Solver (see :class:`uav_tracking_mpc.mpc.solver.Solver`) on IPOPT through CasADi.

    Args:
        problem: What to solve.
        tolerance: Of IPOPT's scaled optimality conditions [-].
        iteration_limit: Per attempt; a solve makes up to two.
        time_limit: Wall time per solve in [s]; IPOPT looks at it once an iteration.

    Attributes:
        last: The plan from which a warm start begins; None after a solve that has failed.

    Raises:
        ValueError: A time limit that is not positive.
    """

    name = "ipopt"

    @one_at_a_time
    def __init__(
        self,
        problem: OptimalControlProblem,
        tolerance: float = 1e-8,
        iteration_limit: int = 200,
        time_limit: float = math.inf,
    ) -> None:
        self.problem = problem
        self._tolerance = tolerance
        self._iteration_limit = iteration_limit
        self._program = NonlinearProgram(problem)
        self.last: Solution | None = None
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
        self._build(min(limit, LONGEST))

    @one_at_a_time
    def _build(self, limit: float) -> None:
        """IPOPT reads its options once: with another budget it is another solver."""
        ipopt: dict[str, Any] = {
            "print_level": 0,
            "sb": "yes",
            "tol": self._tolerance,
            "max_iter": self._iteration_limit,
            "mu_strategy": "adaptive",
            "max_wall_time": limit / 2.0,  # a solve makes up to two attempts
        }
        nlp = self._program.nlp
        self._cold = ca.nlpsol("tracking", "ipopt", nlp, {**OPTIONS, "ipopt": ipopt})
        # Derivatives take longer to make than the rest.
        made = {option: self._cold.get_function(name) for option, name in DERIVATIVES.items()}
        warm: dict[str, Any] = {**OPTIONS, **made, "ipopt": {**ipopt, **WARM}}
        self._warm = ca.nlpsol("tracking", "ipopt", nlp, warm)

    def change(self, problem: OptimalControlProblem) -> None:
        """See :meth:`uav_tracking_mpc.mpc.solver.Solver.change`."""
        self.problem = problem
        self._program.bound(problem)
        self.reset()

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""
        self.last = None

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
            x_0, p = solve_data(problem, initial_state, parameters)
        except (TypeError, ValueError) as error:
            return self._unsolved(Status.REFUSED, str(error), begin)
        warm = [(self.last, None)] if elapsed is not None and self.last is not None else []
        solutions: list[Solution] = []
        for last, make in (*warm, (None, guess), (None, None)):
            self._nlpsol = self._cold if last is None else self._warm
            guesses = plan_guesses(
                problem,
                x_0,
                last,
                elapsed,
                make,
                lambda inputs, decision: self._program.rollout(x_0, inputs, p, decision),
            )
            for start in guesses[: 2 - len(solutions)]:
                solutions.append(self._solve_from(*start, x_0, p, begin))
            if solutions[-1].status in (Status.CONVERGED, Status.TIME_LIMIT):
                break
        solution = min(solutions, key=lambda s: (not s.converged, s.violation > 1e-6, s.cost))
        self.last = solution if solution.converged else None
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
