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

"""The closed loop on the prediction model itself: what campaigns and maps run by the thousand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.mpc.solver import Guess, Solver


class ClosedLoop(NamedTuple):
    """A flight on the prediction model.

    Attributes:
        states: x_0, x_1, ..., shape (steps + 1, nx).
        inputs: u_0 of each plan, shape (steps, nu).
        costs: V_N at each step, shape (steps,).
        failures: Solves that did not converge.
    """

    states: NDArray[np.float64]
    inputs: NDArray[np.float64]
    costs: NDArray[np.float64]
    failures: int


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


def closed_loop(
    solver: Solver, initial_state: ArrayLike, steps: int, parameters: ArrayLike | None = None
) -> ClosedLoop:
    """A flight of :func:`solutions`.

    Args:
        solver: Solves the problem; forgets what it knew.
        initial_state: x_0, shape (nx,).
        steps: Number of steps.
        parameters: The same at every step, of either shape that :meth:`Solver.solve` takes.
    """
    flown = list(islice(solutions(solver, initial_state, parameters), steps))
    return ClosedLoop(
        states=np.array([np.asarray(initial_state), *(each.states[1] for each in flown)]),
        inputs=np.array([each.inputs[0] for each in flown]),
        costs=np.array([each.cost for each in flown]),
        failures=sum(not each.converged for each in flown),
    )
