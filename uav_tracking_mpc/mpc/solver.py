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

"""The interface that every solver shares, what a solve gives back, and a flight of its plans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from enum import Enum
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.problem import OptimalControlProblem

FEASIBLE_VIOLATION = 1e-2  # -, violation of hard constraints, scaled, that a plan may be flown with


class Status(Enum):
    """How a solve ended; the value is what people read."""

    CONVERGED = "converged"
    ITERATION_LIMIT = "iteration limit"
    TIME_LIMIT = "time limit"
    INFEASIBLE = "infeasible"
    FAILED = "failed"
    REFUSED = "refused"


class Solution(NamedTuple):
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


class Guess(NamedTuple):
    """A plan that the caller knows.

    Attributes:
        inputs: u_0..u_{N-1}, shape (N, nu).
        decision: a, shape (na,).
    """

    inputs: NDArray[np.float64]
    decision: NDArray[np.float64]


class Solver(Protocol):
    """Solves one problem again and again, from one state after the other.

    A solver keeps its last converged plan and starts from it, moved on by the time that has passed.
    It never raises on data and never returns an input that is not finite or outside the box: bad
    data gives :attr:`Status.REFUSED` and leaves everything that the solver holds as it was.

    Attributes:
        problem: What it solves.
        time_limit: Time budget of one solve in [s], may be set between solves; inf for none.
    """

    problem: OptimalControlProblem
    time_limit: float

    @property
    def name(self) -> str:
        """By which it is chosen."""

    def solve(
        self,
        initial_state: ArrayLike,
        parameters: ArrayLike | None = None,
        elapsed: float | None = None,
        guess: Callable[[], Guess | None] | None = None,
    ) -> Solution:
        """Solve P_N(x_0), (16).

        Args:
            initial_state: x_0, shape (nx,).
            parameters: p_0..p_N, shape (N + 1, np), or (np,) where they do not change; None for
                those of the problem.
            elapsed: Time in [s] since the state of the last solve, for the warm start; None for a
                cold start.
            guess: Called where a cold start is needed, also after a warm one has failed. The cold
                start tries the plan that it returns first, and others only if that fails.
        """

    def change(self, problem: OptimalControlProblem) -> None:
        """Solve the problem with other numbers from now on, starting cold.

        Args:
            problem: Of the same expressions; bounds, goal and ``parameter_values`` may differ.
        """

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""


def solve_data(
    problem: OptimalControlProblem, initial_state: ArrayLike, parameters: ArrayLike | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """x_0, shape (nx,), and p_0..p_N, shape (N + 1, np), from the arguments of a solve.

    Raises:
        ValueError: Sizes disagree, or a number is not finite.
    """
    x_0 = np.asarray(initial_state, dtype=float).reshape(problem.nx)
    p = np.zeros((problem.horizon + 1, problem.np))
    p[:] = problem.usual_parameter if parameters is None else np.asarray(parameters, dtype=float)
    if not (np.all(np.isfinite(x_0)) and np.all(np.isfinite(p))):
        raise ValueError(f"initial state {x_0} or a parameter is not finite")
    return x_0, p


def shift(samples: NDArray[np.float64], stages: float) -> NDArray[np.float64]:
    """Move a sequence forward in time by linear interpolation; the last sample is held.

    Args:
        samples: Values at stages 0..n-1, shape (n, m).
        stages: Elapsed time over T_s, any number >= 0 [-].

    Returns:
        Values at stages 0..n-1 from then on, shape (n, m).
    """
    count = len(samples)
    where = np.minimum(np.arange(count) + stages, count - 1.0)
    below = where.astype(int)
    above = np.minimum(below + 1, count - 1)
    weight = (where - below)[:, np.newaxis]
    return (1.0 - weight) * samples[below] + weight * samples[above]


def solutions(
    solver: Solver,
    initial_state: ArrayLike,
    parameters: ArrayLike | None = None,
    guess: Callable[[NDArray[np.float64]], Guess | None] | None = None,
) -> Iterator[Solution]:
    """Apply u_0 of each plan to x+ = f(x, u), the model of the problem, from a cold start.

    A plan obeys the dynamics exactly where its solver rolls them out, so x_1 of the plan is the
    next state and nothing is simulated twice. With a solver that meets the dynamics to a
    tolerance (an interior point), so does the flight.

    Args:
        solver: Solves the problem; forgets what it knew.
        initial_state: x_0, shape (nx,).
        parameters: The same at every step, see :meth:`Solver.solve`.
        guess: Plan to begin a cold start with, from the state, shape (nx,).

    Yields:
        Solution at each step, without end.
    """
    solver.reset()
    state, elapsed = np.asarray(initial_state, dtype=float), None
    while True:
        start = None if guess is None else partial(guess, state)
        solution = solver.solve(state, parameters, elapsed, start)
        yield solution
        state, elapsed = solution.states[1], solver.problem.step
