"""The paper's problem (14)-(16), fed with a situation: no drift, no envelope, one orbit."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import relative_state, tracking_error
from uav_tracking_mpc.estimation.forecast import Forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import Plan, solver_of
from uav_tracking_mpc.formulation.paper_problem import problem_of, stability_problem, terminal_level
from uav_tracking_mpc.mpc.solver import Solver
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.terminal.decrease import decrease_monitor


class PaperFormulation:
    """The paper's optimal control problem and its solver.

    Args:
        parameters: What is flown.
        solver: Of this problem; made as the parameters say by default.
    """

    def __init__(self, parameters: TrackingParameters, solver: Solver | None = None) -> None:
        self.step = parameters.horizon_step
        self.solver = solver or solver_of(problem_of(parameters), parameters)
        self.decrease = decrease_monitor(stability_problem(parameters), terminal_level(parameters))
        self._steady_inputs = parameters.steady_inputs
        self._target = np.full(3, np.nan)

    def change(self, parameters: TrackingParameters) -> None:
        """Take a new time budget; nothing else that changes in flight is in the problem.

        Args:
            parameters: The new ones.
        """
        self.solver.time_limit = parameters.solve_time_max

    def reset(self) -> None:
        """Forget the last plan."""
        self.solver.reset()
        self.decrease.reset()

    def solve(
        self, situation: Situation, forecast: Forecast, orbit: Orbit, elapsed: float | None
    ) -> Plan:
        """See :meth:`Formulation.solve`; the target is taken to stand and the air to be still."""
        error = tracking_error(relative_state(situation.vehicle, situation.target), orbit)
        solution = self.solver.solve(error, elapsed=elapsed)
        moved = bool(np.any(np.abs(situation.target - self._target) > 0.0))
        self._target = situation.target
        decrease = self.decrease.step(
            solution.cost if solution.converged else float("nan"),
            error,
            solution.states[-1],
            target_moved=moved,
            fraction=1.0 if elapsed is None else elapsed / self.step,
        )
        inputs = solution.inputs + self._steady_inputs
        return Plan(inputs, self.step, error, solution, decrease=decrease)
