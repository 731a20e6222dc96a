"""The problem as a nonlinear program, handed to fatrop or IPOPT through CasADi.

Multiple shooting with the variables stage by stage, [x_i, a_i, u_i, s_i] for i < N and
[x_N, a_N, s_N] at the end: a is carried as a state with a_{i+1} = a_i, s >= 0 are the violations of
the soft inequalities. fatrop exploits exactly this order; IPOPT takes any.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution, Status
from uav_tracking_mpc.mpc.solver import Guess, shift

PLUGINS = ("ipopt", "fatrop")
FEASIBILITY_TOLERANCE = 1e-5
LONGEST = 1e9  # s, of a solve without a budget: IPOPT has no infinite one


class CasadiSolver:
    """Solver (see :class:`uav_tracking_mpc.mpc.solver.Solver`) on a CasADi plugin.

    Args:
        problem: What to solve.
        plugin: ``ipopt`` or ``fatrop``. fatrop is four times as fast, but has been seen never to
            return where the model has no value (a state outside its domain): not for flight.
        tolerance: Of the plugin's scaled optimality conditions [-].
        iteration_limit: Per solve.
        time_limit: Wall time per solve in [s], IPOPT only, which looks at it once an iteration.

    Raises:
        ValueError: Unknown plugin, or a time limit that is not positive.
    """

    def __init__(
        self,
        problem: OptimalControlProblem,
        plugin: str = "ipopt",
        tolerance: float = 1e-8,
        iteration_limit: int = 200,
        time_limit: float = 1.0,
    ) -> None:
        if plugin not in PLUGINS:
            raise ValueError(f"plugin is {plugin!r}, must be one of {', '.join(PLUGINS)}")
        self.name = plugin
        self.problem = problem
        self._tolerance = tolerance
        self._iteration_limit = iteration_limit
        self._program = _Program(problem)
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
        self._nlpsol = ca.nlpsol("tracking", self.name, self._program.nlp, options)

    def _options(self, plugin: str, tolerance: float, time_limit: float) -> dict[str, Any]:
        options: dict[str, Any] = {"print_time": False, "expand": True, "error_on_fail": False}
        options["show_eval_warnings"] = False
        if plugin == "ipopt":
            options["ipopt"] = {
                "print_level": 0,
                "sb": "yes",
                "tol": tolerance,
                "max_iter": self._iteration_limit,
                "max_wall_time": time_limit / 2.0,  # a cold solve makes two attempts
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
            if parameters is not None:
                p[:] = np.asarray(parameters, dtype=float)
        except (TypeError, ValueError) as error:
            return self._unsolved(Status.REFUSED, str(error), begin)
        if not (np.all(np.isfinite(x_0)) and np.all(np.isfinite(p))):
            message = f"initial state {x_0} or a parameter is not finite"
            return self._unsolved(Status.REFUSED, message, begin)
        guesses = self._guesses(x_0, elapsed, guess)
        solutions = [self._solve_from(*guess, x_0, p, begin) for guess in guesses]
        solution = min(solutions, key=lambda s: (not s.converged, s.violation > 1e-6, s.cost))
        self._last = solution if solution.converged else None
        return solution

    def _guesses(
        self,
        x_0: NDArray[np.float64],
        elapsed: float | None,
        make: Callable[[], Guess | None] | None,
    ) -> list[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
        """Plans to start from: the last one moved on, or two cold ones."""
        problem, last = self.problem, self._last
        if elapsed is not None and last is not None:
            stages = max(0.0, elapsed) / problem.step
            states = shift(last.states, stages)
            states[0] = x_0
            return [(states, shift(last.inputs, stages), last.decision)]
        inputs = np.tile(problem.input_rest, (problem.horizon, 1))
        guess = make() if make is not None else None
        if guess is not None:
            still = np.tile(x_0, (problem.horizon + 1, 1))
            return [(still, np.asarray(guess.inputs), np.asarray(guess.decision))]
        goal = np.zeros(problem.nx) if problem.state_goal is None else problem.state_goal
        later = (problem.horizon, 1)
        return [
            (np.vstack([x_0, np.tile(rest, later)]), inputs, problem.decision_guess)
            for rest in (goal, x_0)
        ]

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


class _Program:
    """Variables, bounds and constraints of the nonlinear program, stage by stage."""

    def __init__(self, problem: OptimalControlProblem) -> None:
        self.problem = problem
        x, u, p, a = problem.state, problem.inputs, problem.parameter, problem.decision
        n, nx, nu, na = problem.horizon, problem.nx, problem.nu, problem.na
        stage_hard, stage_soft, stage_penalty = _split(problem.stage_inequalities)
        end_hard, end_soft, end_penalty = _split(problem.terminal_inequalities)
        soft = stage_soft.numel()
        stage = ca.Function(
            "stage", [x, u, p, a], [problem.next_state, problem.stage_cost, stage_hard, stage_soft]
        )
        end = ca.Function(
            "end", [x, p, a], [problem.terminal_cost, problem.terminal_equality, end_hard, end_soft]
        )
        initial = ca.SX.sym("initial", nx)
        values = ca.SX.sym("p", problem.np, n + 1)

        variables, lower, upper = [], [], []
        constraints, equality = [], []
        cost = ca.SX(0)
        self.ng = []
        xs = [ca.SX.sym(f"x{i}", nx) for i in range(n + 1)]
        decisions = [ca.SX.sym(f"a{i}", na) for i in range(n + 1)]

        def vary(symbol: ca.SX, least: Any = -np.inf, greatest: Any = np.inf) -> None:
            variables.append(symbol)
            lower.append(np.broadcast_to(least, symbol.numel()))
            upper.append(np.broadcast_to(greatest, symbol.numel()))

        def constrain(expression: ca.SX, is_equality: bool) -> int:
            constraints.append(expression)
            equality.extend([is_equality] * expression.numel())
            return int(expression.numel())

        for i in range(n):
            ui, si = ca.SX.sym(f"u{i}", nu), ca.SX.sym(f"s{i}", soft)
            vary(xs[i])
            vary(decisions[i], problem.decision_lower, problem.decision_upper)
            vary(ui, problem.input_lower, problem.input_upper)
            vary(si, 0.0)
            following, stage_cost, hard, soft_value = stage(xs[i], ui, values[:, i], decisions[i])
            cost += stage_cost + ca.dot(stage_penalty, si)
            constrain(xs[i + 1] - following, True)  # (16b)
            constrain(decisions[i + 1] - decisions[i], True)
            count = constrain(xs[0] - initial, True) if i == 0 else 0
            count += constrain(hard, False) + constrain(soft_value - si, False)
            self.ng.append(count)
        s_end = ca.SX.sym("s_end", end_soft.numel())
        vary(xs[n])
        vary(decisions[n], problem.decision_lower, problem.decision_upper)
        vary(s_end, 0.0)
        end_cost, end_equal, hard, soft_value = end(xs[n], values[:, n], decisions[n])
        cost += end_cost + ca.dot(end_penalty, s_end)
        count = constrain(end_equal, True)
        count += constrain(hard, False) + constrain(soft_value - s_end, False)  # (16e)
        self.ng.append(count)

        self.nx = [nx + na] * (n + 1)
        self.nu = [nu + soft] * n + [s_end.numel()]
        self.equality = equality
        self.constraint_lower = np.where(equality, 0.0, -np.inf)
        self.lower, self.upper = np.concatenate(lower), np.concatenate(upper)
        self.nlp = {
            "x": ca.vertcat(*variables),
            "f": cost,
            "g": ca.vertcat(*constraints),
            "p": ca.vertcat(initial, ca.vec(values)),
        }
        self._stage_size = nx + na + nu + soft

    def pack(
        self,
        states: NDArray[np.float64],
        inputs: NDArray[np.float64],
        decision: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Variables of the program from a plan; slacks start at 0."""
        nx, nu, na, n = self.problem.nx, self.problem.nu, self.problem.na, self.problem.horizon
        variables = np.zeros(len(self.lower))
        stages = variables[: n * self._stage_size].reshape(n, self._stage_size)
        stages[:, :nx] = states[:n]
        stages[:, nx : nx + na] = decision
        stages[:, nx + na : nx + na + nu] = inputs
        end = variables[n * self._stage_size :]
        end[:nx] = states[n]
        end[nx : nx + na] = decision
        return variables

    def unpack(
        self, variables: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Plan (states, inputs, decision) from the variables of the program."""
        nx, nu, na, n = self.problem.nx, self.problem.nu, self.problem.na, self.problem.horizon
        stages = variables[: n * self._stage_size].reshape(n, self._stage_size)
        end = variables[n * self._stage_size :]
        states = np.vstack([stages[:, :nx], end[:nx]])
        return states, stages[:, nx + na : nx + na + nu].copy(), stages[0, nx : nx + na].copy()


def _split(inequalities: tuple[Inequality, ...]) -> tuple[ca.SX, ca.SX, ca.DM]:
    """Hard expressions, soft expressions, and the penalty of each soft one."""
    hard = ca.vertcat(ca.SX.zeros(0, 1), *(h.expression for h in inequalities if h.penalty is None))
    soft = [h for h in inequalities if h.penalty is not None]
    expressions = ca.vertcat(ca.SX.zeros(0, 1), *(h.expression for h in soft))
    penalties = [h.penalty for h in soft for _ in range(h.expression.numel())]
    return hard, expressions, ca.DM(np.array(penalties, dtype=float).reshape(-1, 1))
