"""The closed loop on the prediction model itself: what campaigns and maps run by the thousand."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.solver import Solver


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


def closed_loop(
    solver: Solver, initial_state: ArrayLike, steps: int, parameters: ArrayLike | None = None
) -> ClosedLoop:
    """Apply u_0 of each plan to x+ = f(x, u), the model of the problem, from a cold start.

    A plan obeys the dynamics exactly where its solver rolls them out, so x_1 of the plan is the
    next state and nothing is simulated twice. With a solver that meets the dynamics to a
    tolerance (an interior point), so does the flight.

    Args:
        solver: Solves the problem; forgets what it knew.
        initial_state: x_0, shape (nx,).
        steps: Number of steps.
        parameters: The same at every step, of either shape that :meth:`Solver.solve` takes.
    """
    problem = solver.problem
    states = np.empty((steps + 1, problem.nx))
    inputs = np.empty((steps, problem.nu))
    costs = np.empty(steps)
    states[0] = initial_state
    failures = 0
    solver.reset()
    elapsed = None
    for step in range(steps):
        solution = solver.solve(states[step], parameters, elapsed)
        inputs[step] = solution.inputs[0]
        states[step + 1] = solution.states[1]
        costs[step] = solution.cost
        failures += not solution.converged
        elapsed = problem.step
    return ClosedLoop(states, inputs, costs, failures)
