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
A cold start makes several attempts, the best of which is kept.

The problem has local minima. So a cold start tries inputs at rest, feedback to the goal, and that
feedback after a few stages with inputs held near a bound ("openings"), in the order of what they
cost without any step. An attempt that will not end below the best plan is given up.

A long horizon has many local minima and a short one few. So beyond :data:`SHORT_HORIZON` every
opening is tried on a horizon of that length, without terminal constraints, which belong to the end
of the whole one; the two best plans, extended by the feedback, are then the guesses for the whole
horizon, next to inputs at rest and plain feedback. If none of these converges, the openings are
tried on the whole horizon, until one does.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.compiled_method import CompiledMethod, compile_method
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Guess, Solution, Status
from uav_tracking_mpc.mpc.stage_code import multiplier_intervals
from uav_tracking_mpc.symbolic.functions import one_at_a_time

SHORT_HORIZON = 20  # stages that a cold start is compiled for as a whole
COARSE_TOLERANCE, COARSE_ITERATIONS = 1e-3, 40  # -, tolerance of attempts on the short horizon
DISTINCT = 1e-3  # -, relative difference in cost between two local minima
OPENING_STAGES = 4  # in which an opening's inputs act
COMBINED_INPUTS = 3  # count of inputs that openings hold at their bounds in every combination
FEASIBLE = 1e-6  # -, tolerance of violations within which the cheaper plan is the better
OPENING_SHARE = 0.9  # -, of the way from the middle of the box to its bound
MULTIPLIER_WEIGHT = 10.0  # -, rho, the penalty weight to begin with
# -, rho, the penalty weight to begin with from a guess, one after the other until one converges. A
# guess nearly meets the constraints and should not leave them far behind for a lower cost: on the
# other side of a bearing of pi there may be no way back to them. Yet some get stuck on them.
GUESS_WEIGHTS = (10000.0, 10.0, 1000.0)
RESCUE_WEIGHTS = (1000.0, 10.0)  # -, penalty weights of the openings on a whole long horizon
PLAN_FIELDS = ("x", "u", "a", "c", "value", "mu", "rho")

# -, relative difference in cost for which an attempt is finished once another has converged
WORTHWHILE = 1e-5
INSIDE = -1e6  # -, value of a constraint that is so far inside that a sweep takes it as inactive

Attempt = Callable[[int, float, int, float], int]
# Inputs of the first stages, shape (stages, nu), decision, shape (na,), and penalty weight
Start = tuple[NDArray[np.float64], NDArray[np.float64], float]


class ColdStart:
    """Attempts at one compiled problem.

    Args:
        problem: What is solved.
        method: The method compiled for it.
        record: Its workspace.

    Attributes:
        iterations: Newton iterations of the last cold start.
    """

    def __init__(
        self, problem: OptimalControlProblem, method: CompiledMethod, record: np.void
    ) -> None:
        self._codes = method.minimise
        self._record = {field: record[field] for field in record.dtype.names or ()}  # views
        self._plan = [record[field] for field in PLAN_FIELDS]
        self._horizon, self._ends = method.stage.N, method.stage.NE
        rows = method.workspace
        self._kept, self._reference = int(rows.KEPT), int(rows.SECOND)
        self._working, spare = int(rows.WORKING), int(rows.SPARE)
        self._best, self._short = spare, (spare + 1, spare + 2)
        self._rest = problem.input_rest
        guess = record["a_guess"]
        self._openings = [
            (inputs, guess, MULTIPLIER_WEIGHT) for inputs in openings(problem, self._rest)
        ]
        self._policy = np.zeros_like(record["K"][0])  # gains of the feedback to the goal
        self.iterations = 0

    def __call__(
        self, attempt: Attempt, tolerance: float, iteration_limit: int, guess: Guess | None = None
    ) -> int:
        """Run the attempts and leave the best plan in row KEPT.

        Args:
            attempt: (start, tolerance, iteration limit, bound) -> how it ended.
            tolerance: Of the attempts on the whole horizon [-].
            iteration_limit: Of each of them.
            guess: Tried first; if it converges, alone.

        Returns:
            How the best attempt ended.
        """
        codes = self._codes
        self.iterations = 0
        self._set_horizon(self._horizon)

        def run(start: Start, bound: float = math.inf) -> int:
            return self._run(start, lambda code: attempt(code, tolerance, iteration_limit, bound))

        if guess is not None:
            inputs, decision = np.asarray(guess.inputs), np.asarray(guess.decision)
            for weight in GUESS_WEIGHTS:
                end = run((inputs, decision, weight))
                if end in (codes.CONVERGED, codes.TIME_LIMIT):
                    return end
        self._feedback_to_goal(attempt)
        if self._horizon <= SHORT_HORIZON:
            return self._best_of([self._cheapest_first(attempt)], run)
        starts = self._shorter_horizon(attempt)
        rescues = [(*start[:2], weight) for weight in RESCUE_WEIGHTS for start in self._openings]
        groups = [[*starts, *self._openings[:2]], rescues]
        return self._best_of(groups, lambda start, _: run(start))  # few enough to finish each

    def _run(self, start: Start, attempt: Callable[[int], int]) -> int:
        """How an attempt from a start ended."""
        self._prepare(*start)
        end = attempt(self._codes.PREPARED)
        if end != self._codes.NO_START:
            self.iterations += int(self._record["outcome"][0])
        return end

    def _best_of(self, groups: list[list[Start]], run: Callable[[Start, float], int]) -> int:
        """How the best attempt ended; a group is tried if none of those before has converged."""
        codes, record = self._codes, self._record
        best: tuple[bool, float, float] | None = None
        best_end, best_gradient, bound = codes.NO_START, math.nan, math.inf
        for start in itertools.chain.from_iterable(
            group for group in groups if best_end not in (codes.CONVERGED, codes.TIME_LIMIT)
        ):
            end = run(start, bound)
            if end in (codes.NO_START, codes.HOPELESS):
                continue
            _, cost, violation, _ = record["value"][self._kept].tolist()
            rank = (end != codes.CONVERGED, max(violation, FEASIBLE), cost)
            if best is None or rank < best:
                best, best_end, best_gradient = rank, end, record["outcome"][1]
                self._copy(self._kept, self._best)
                if end == codes.CONVERGED:
                    bound = cost - WORTHWHILE * abs(cost)
            if end == codes.TIME_LIMIT:
                break
        if best is not None:
            self._copy(self._best, self._kept)
        record["outcome"][1] = best_gradient
        return best_end

    def _feedback_to_goal(self, attempt: Attempt) -> None:
        """Gains at stage 0 of a Riccati recursion about rest at the goal, into the policy."""
        record, row = self._record, self._reference
        self._prepare(*self._openings[0])
        record["u"][row] = self._rest
        record["c"][row] = INSIDE
        record["c"][row, -1] = 0.0
        attempt(self._codes.SWEEP, 1.0, 1, math.inf)
        gains = record["K"][0]
        self._policy = gains.copy() if np.isfinite(gains).all() else np.zeros_like(gains)

    def _cheapest_first(self, attempt: Attempt) -> list[Start]:
        """The openings in the order of what they cost without any step."""
        promised: list[tuple[float, int, Start]] = []
        for start in self._openings:
            end = self._run(start, lambda code: attempt(code, 1.0, 0, math.inf))
            if end != self._codes.NO_START:
                promised.append((float(self._record["outcome"][2]), len(promised), start))
        return [start for _, _, start in sorted(promised, key=lambda each: each[:2])]

    def _shorter_horizon(self, attempt: Attempt) -> list[Start]:
        """The best distinct plans of a shorter horizon, at most two."""
        record, cost, codes = self._record, self._record["value"][:, 1], self._codes
        found: list[int] = []
        free = list(self._short)
        self._set_horizon(SHORT_HORIZON)
        for start in self._openings:
            end = self._run(
                start, lambda code: attempt(code, COARSE_TOLERANCE, COARSE_ITERATIONS, math.inf)
            )
            if end == codes.NO_START:
                continue
            new = cost[self._kept]
            if any(abs(new - cost[row]) <= DISTINCT * abs(new) for row in found):
                continue
            if not free and new < cost[found[-1]]:
                free.append(found.pop())
            if free:
                row = free.pop()
                self._copy(self._kept, row)
                found = sorted([*found, row], key=lambda r: cost[r])
            if end == codes.TIME_LIMIT:
                break
        self._set_horizon(self._horizon)
        return [
            (record["u"][row, :SHORT_HORIZON].copy(), record["a"][row].copy(), MULTIPLIER_WEIGHT)
            for row in found
        ]

    def _set_horizon(self, stages: int) -> None:
        """Stages of the next attempts; a shorter horizon has no terminal constraints."""
        self._record["horizon"][0] = stages
        self._record["ends"][0] = self._ends if stages == self._horizon else 0

    def _prepare(
        self, inputs: NDArray[np.float64], decision: NDArray[np.float64], weight: float
    ) -> None:
        """Reference of a rollout: given inputs at the first stages, then feedback to the goal."""
        record, row, held = self._record, self._reference, len(inputs)
        record["x"][row] = record["goal"]
        record["u"][row] = self._rest
        record["u"][row, :held] = inputs
        record["a"][row, : len(decision)] = decision
        record["k"][:] = record["k_a"][:] = 0.0
        record["K"][:held] = 0.0
        record["K"][held:] = self._policy
        record["mu"][self._working] = 0.0
        record["rho"][self._working] = weight
        record["residual"][:] = np.inf

    def _copy(self, source: int, target: int) -> None:
        for values in self._plan:
            values[target] = values[source]


def openings(
    problem: OptimalControlProblem, rest: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """Inputs of the first stages, shape (stages, nu), of each opening.

    At rest throughout; none (feedback from the start); each input alone at either end of its box;
    the first inputs together in every combination of ends.

    Args:
        problem: Its box and horizon.
        rest: The inputs at rest, shape (nu,).
    """
    lower, upper = problem.input_lower, problem.input_upper
    bounded = np.isfinite(lower) & np.isfinite(upper)
    lower, upper = np.where(bounded, lower, rest), np.where(bounded, upper, rest)
    middle, reach = 0.5 * (lower + upper), 0.5 * OPENING_SHARE * (upper - lower)
    signs = [sign * unit for unit in np.eye(problem.nu) for sign in (1.0, -1.0)]
    together = min(problem.nu, COMBINED_INPUTS)
    for corner in itertools.product((1.0, -1.0), repeat=together):
        signs.append(np.array([*corner, *np.zeros(problem.nu - together)]))
    held = [np.where(sign == 0.0, rest, middle + sign * reach) for sign in signs]
    whole = np.tile(rest, (min(problem.horizon, SHORT_HORIZON), 1))
    stages = min(OPENING_STAGES, problem.horizon)
    return [whole, whole[:0], *(np.tile(inputs, (stages, 1)) for inputs in held)]


STATUSES = tuple(Status)  # in the order of the codes in newton/minimise.py
CONVERGED, ITERATION_LIMIT, TIME_LIMIT, INFEASIBLE, STALLED, REFUSED, NO_START = range(7)
WARM = 0  # code of a start in newton/minimise.py


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
        self.problem, record = problem, self._workspace[0]
        kept = int(self._method.workspace.KEPT)
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
        self._states = record["x"][kept]
        self._inputs = record["u"][kept]
        self._decision = record["a"][kept][: problem.na]
        self._value = record["value"][kept]
        self._outcome = record["outcome"]
        record["horizon"][0], record["ends"][0] = problem.horizon, intervals[1].shape[1]
        self._cold_start = ColdStart(problem, self._method, record)
        self._warm = False

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
            return self._without_plan(Status.REFUSED, str(error), begin)
        deadline = begin + self.time_limit
        code = iterations = 0
        if warm:
            code = self._run(
                self._address,
                WARM,
                stages,
                self.tolerance,
                self.iteration_limit,
                deadline,
                math.inf,
            )
            iterations = int(self._outcome[0])
        if not warm or code not in (CONVERGED, TIME_LIMIT, REFUSED):
            code = self._cold(deadline, guess)
            iterations += self._cold_start.iterations
        if code == REFUSED:
            reason = "initial state or a parameter is not finite"
            return self._without_plan(Status.REFUSED, reason, begin)
        if code == NO_START:  # what is kept is an older plan, or none
            self._warm = False
            reason = "the dynamics are not finite from this state under any initial guess"
            return self._without_plan(Status.FAILED, reason, begin)
        if code == INFEASIBLE and self._value[2] <= self.tolerance:
            code = STALLED  # the weights are at their limit, but the plan meets the constraints
        # A plan that ran out of time obeys the dynamics and is worth going on from; any other
        # that has not converged is not.
        self._warm = code in (CONVERGED, TIME_LIMIT)
        _, cost, violation, _ = self._value.tolist()
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

    def _cold(self, deadline: float, guess: Callable[[], Guess | None] | None) -> int:
        def attempt(start: int, tolerance: float, limit: int, bound: float) -> int:
            return self._run(self._address, start, 0.0, tolerance, limit, deadline, bound)

        # Before anything of the last plan is overwritten.
        if not (np.isfinite(self._x_0).all() and np.isfinite(self._p).all()):
            self._cold_start.iterations = 0
            return REFUSED
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
        return f"failed: no step lowers the cost, gradient {gradient:.3g}"

    def _without_plan(self, status: Status, reason: str, begin: float) -> Solution:
        return Solution.without_plan(self.problem, status, reason, time.perf_counter() - begin)
