"""The control law kappa_N of (21) as a flight needs it: a command at every call, always finite."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.guidance.tracking_parameters import TrackingParameters
from uav_tracking_mpc.guidance.tracking_problem import (
    stability_problem,
    terminal_level,
    tracking_problem,
)
from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.mpc.solver import Solver
from uav_tracking_mpc.stability.decrease import DecreaseCheck, decrease_monitor


class Source(Enum):
    """Where a command comes from; the value is what people read."""

    OPTIMAL = "optimal plan"
    EARLIER_PLAN = "earlier plan"
    WINGS_LEVEL = "wings level"


@dataclass(frozen=True)
class Command:
    """What to fly now and, should nothing follow, after that.

    Attributes:
        inputs: (u_psi, u_chi, u_v) at 0, T_s, 2 T_s, ..., shape (n, 3), inside U; held in between.
        step: T_s in [s].
        source: Where it comes from.
        reason: Why it is not optimal; empty if it is.
        error: Tracking error x, shape (5,).
        solution: What the solver said.
        decrease: Whether the optimal cost fell as (54) says; None where that cannot be told.
    """

    inputs: NDArray[np.float64]
    step: float
    source: Source
    reason: str
    error: NDArray[np.float64]
    solution: Solution
    decrease: DecreaseCheck | None


def tracking_solver(parameters: TrackingParameters) -> Solver:
    """Solver that the parameters name, for the problem that they describe."""
    problem = tracking_problem(parameters)
    if parameters.solver == "newton":
        return NewtonSolver(problem, time_limit=parameters.solve_time_max)
    return CasadiSolver(problem, parameters.solver, time_limit=parameters.solve_time_max)


class TrackingController:
    """NMPC of Section 4 about one orbit.

    Args:
        parameters: What to fly and how.
        solver: Solves the problem of these parameters; made from them by default.
    """

    def __init__(self, parameters: TrackingParameters, solver: Solver | None = None) -> None:
        self.parameters = parameters
        self.solver = solver or tracking_solver(parameters)
        self.steady_inputs = parameters.steady_inputs
        self.decrease = decrease_monitor(stability_problem(parameters), terminal_level(parameters))
        # The path angle is taken out no faster than commands can follow it.
        period = 1.0 / parameters.control_rate
        self._levelling_time = max(1.0, parameters.horizon_step, 2.0 * period)
        self._plan: NDArray[np.float64] | None = None
        self._plan_age = 0.0

    def reset(self) -> None:
        """Forget every plan."""
        self.solver.reset()
        self.decrease.reset()
        self._plan = None

    def step(
        self, relative: ArrayLike, elapsed: float | None = None, target_moved: bool = False
    ) -> Command:
        """Command for the vehicle's present state relative to the target.

        Args:
            relative: (r, theta, z, chi, v), shape (5,), in [m, rad, m, rad, m/s].
            elapsed: Time in [s] since the state of the last call; None at the first.
            target_moved: Whether the target is known to have moved since then.
        """
        error = tracking_error(relative, self.parameters.orbit)
        if elapsed is not None:
            self._plan_age += max(0.0, elapsed)
        solution = self.solver.solve(error, elapsed=elapsed)
        decrease = self.decrease.step(
            solution.cost if solution.converged else float("nan"),
            error,
            solution.states[-1],
            target_moved=target_moved,
            fraction=1.0 if elapsed is None else elapsed / self.parameters.horizon_step,
        )
        if solution.converged:
            self._plan = self._inside(solution.inputs + self.steady_inputs)
            self._plan_age = 0.0
            return self._command(self._plan, Source.OPTIMAL, "", error, solution, decrease)
        remaining = self._remaining_plan()
        if remaining is not None:
            source = Source.EARLIER_PLAN
            return self._command(remaining, source, solution.message, error, solution, decrease)
        level = np.zeros((1, 3))
        path_angle = float(np.asarray(relative, dtype=float)[3])
        if np.isfinite(path_angle):
            level[0, 1] = -path_angle / self._levelling_time
        source = Source.WINGS_LEVEL
        return self._command(
            self._inside(level), source, solution.message, error, solution, decrease
        )

    def _remaining_plan(self) -> NDArray[np.float64] | None:
        """What is left of the last optimal plan, if it is young enough to be flown."""
        if self._plan is None or self._plan_age > self.parameters.plan_age_max:
            return None
        flown = int(self._plan_age / self.parameters.horizon_step)
        remaining = self._plan[flown:]
        return remaining if len(remaining) else None

    def _inside(self, inputs: NDArray[np.float64]) -> NDArray[np.float64]:
        # Adding u_ss to a bound of u can leave U by a rounding error.
        return np.clip(inputs, self.parameters.input_lower, self.parameters.input_upper)

    def _command(
        self,
        inputs: NDArray[np.float64],
        source: Source,
        reason: str,
        error: NDArray[np.float64],
        solution: Solution,
        decrease: DecreaseCheck | None,
    ) -> Command:
        step = self.parameters.horizon_step
        return Command(inputs, step, source, reason, error, solution, decrease)
