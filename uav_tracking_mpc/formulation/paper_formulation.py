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

"""The paper's problem (14)-(16), fed with a situation: no drift, no envelope, one orbit."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import relative_state, tracking_error
from uav_tracking_mpc.dynamics.response import Response
from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time
from uav_tracking_mpc.estimation.forecast import Forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import Plan, SolverMaker, solver_of
from uav_tracking_mpc.formulation.paper_problem import problem_of, stability_problem, terminal_level
from uav_tracking_mpc.mpc.solver import Solver
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.terminal.decrease import decrease_monitor


class _About:
    """All that the problem takes from an orbit: x_ss, u_ss, P_rho, varrho and the bound of (54)."""

    @one_at_a_time
    def __init__(self, parameters: TrackingParameters) -> None:
        problem = stability_problem(parameters)
        self.orbit = parameters.orbit
        self.problem = problem_of(parameters, problem)
        self.steady_inputs = parameters.steady_inputs
        self.decrease = decrease_monitor(problem, terminal_level(parameters, problem))


class PaperFormulation:
    """The paper's optimal control problem and its solver.

    Args:
        parameters: What is flown.
        solver: Of this problem; made by default.
        make_solver: Makes it, as the parameters say.
    """

    def __init__(
        self,
        parameters: TrackingParameters,
        solver: Solver | None = None,
        make_solver: SolverMaker = solver_of,
    ) -> None:
        self.step = parameters.horizon_step
        self._flown = _About(parameters)
        self._next = self._flown
        self.solver = solver or make_solver(self._flown.problem, parameters)
        self.decrease = self._flown.decrease
        self._target = np.full(3, np.nan)

    def check(self, parameters: TrackingParameters) -> None:
        """See :meth:`Formulation.check`.

        Raises:
            ParameterError: There is no terminal controller for this orbit.
        """
        if parameters.orbit != self._next.orbit:
            self._next = _About(parameters)

    def change(self, parameters: TrackingParameters) -> None:
        """Take a new orbit, with its terminal ingredients, and a new time budget.

        Args:
            parameters: The new ones.

        Raises:
            ParameterError: As of :meth:`check`; nothing has changed.
        """
        if parameters.orbit != self._flown.orbit:
            self.check(parameters)
            self._flown, self.decrease = self._next, self._next.decrease.after(self.decrease)
            self.solver.change(self._flown.problem)
        self.solver.time_limit = parameters.solve_time_max

    def respond(self, response: Response) -> None:
        """See :meth:`Formulation.respond`: the paper's aircraft answers at once."""

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
        inputs = solution.inputs + self._flown.steady_inputs
        return Plan(inputs, self.step, error, solution, decrease=decrease)
