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
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import (
    orbit_dynamics,
    orbit_numbers,
    relative_state,
    tracking_error,
)
from uav_tracking_mpc.dynamics.vehicle import Response
from uav_tracking_mpc.estimation.situation import Forecast, Situation
from uav_tracking_mpc.formulation.formulation import Plan, SolverMaker, solver_of
from uav_tracking_mpc.mpc.problem import OptimalControlProblem, TerminalSet, quadratic_problem
from uav_tracking_mpc.parameters.specification import ParameterError, refuse_fixed
from uav_tracking_mpc.settings.tracking import ARTIFICIAL_ORBIT, PaperParameters
from uav_tracking_mpc.symbolic.functions import one_at_a_time
from uav_tracking_mpc.terminal.decrease import DecreaseMonitor
from uav_tracking_mpc.terminal.ingredients import StabilityProblem, input_limited_level

# -, of the level: at the very limit rounding decides whether K x is in U, and no proof closes.
LEVEL_MARGIN = 1.0 - 2e-6
# What the expressions of the problem hold as numbers: only the orbit can be another in flight.
COMPILED = (
    "state_weights", "input_weights", "terminal_scaling", "terminal_penalty", "yaw_rate_max",
    "pitch_rate_max", "acceleration_min", "acceleration_max",
)  # fmt: skip


def stability_problem(parameters: PaperParameters, name: str = "unnamed") -> StabilityProblem:
    """Orbit, model, weights and input set of parameters.

    Args:
        parameters: What is flown.
        name: What a report calls it.
    """
    return StabilityProblem(
        orbit=parameters.orbit,
        state_weight=np.diag(parameters.state_weights),
        input_weight=np.diag(parameters.input_weights),
        scaling=parameters.terminal_scaling,
        input_lower=parameters.input_lower,
        input_upper=parameters.input_upper,
        step=parameters.horizon_step,
        horizon=parameters.horizon,
        model=parameters.model,
        scheme=parameters.scheme,
        name=name,
    )


def terminal_level(parameters: PaperParameters, problem: StabilityProblem) -> float | None:
    """Varrho of X_f (25), as large as U allows; None where no terminal set is asked for.

    Args:
        parameters: What is flown.
        problem: Of these parameters.
    """
    if parameters.terminal_constraint == "none":
        return None
    return LEVEL_MARGIN * input_limited_level(problem.ingredients(), *problem.deviation_bounds())


def problem_of(
    parameters: PaperParameters, problem: StabilityProblem | None = None
) -> OptimalControlProblem:
    """P_N(x_0), (16), of parameters; those that differ in the orbit have the same expressions.

    Args:
        parameters: What is flown.
        problem: Of these parameters; made from them by default.

    Raises:
        ParameterError: No stabilising terminal controller for this orbit and these weights.
    """
    penalty = parameters.terminal_penalty if parameters.terminal_constraint == "soft" else None
    problem = problem or stability_problem(parameters)
    try:
        return tracking_problem(problem, terminal_level(parameters, problem), penalty)
    except (ValueError, np.linalg.LinAlgError) as error:
        raise ParameterError(
            "parameters 'state_weights', 'input_weights', 'terminal_scaling' and the orbit give no "
            f"problem that can be solved: {error}"
        ) from error


def tracking_problem(
    problem: StabilityProblem, level: float | None, penalty: float | None = None
) -> OptimalControlProblem:
    """(14)-(16) in tracking errors x = xbar - x_ss, u = ubar - u_ss.

    Args:
        problem: The configuration.
        level: varrho [-] of the terminal set (16e); None leaves it away.
        penalty: None to enforce the terminal set; else the L1 weight of a violation [-].
    """
    lower, upper = problem.deviation_bounds()
    return quadratic_problem(
        orbit_dynamics(problem.model, problem.step, problem.scheme),
        reference=orbit_numbers(problem.model, problem.orbit),
        horizon=problem.horizon,
        step=problem.step,
        state_weight=problem.state_weight,
        input_weight=problem.input_weight,
        terminal_weight=problem.ingredients().weight,
        input_lower=lower,
        input_upper=upper,
        terminal_set=None if level is None else TerminalSet(level, penalty),
    )


class _About:
    """All that the problem takes from an orbit: x_ss, u_ss, P_rho, varrho and the bound of (54)."""

    @one_at_a_time
    def __init__(self, parameters: PaperParameters) -> None:
        problem = stability_problem(parameters)
        self.orbit = parameters.orbit
        self.problem = problem_of(parameters, problem)
        self.steady_inputs = parameters.steady_inputs
        self.decrease = DecreaseMonitor(problem, terminal_level(parameters, problem))


class PaperFormulation:
    """The paper's optimal control problem and its solver.

    Args:
        parameters: What is flown.
        make_solver: Makes the solver of its problem.
    """

    def __init__(self, parameters: PaperParameters, make_solver: SolverMaker = solver_of) -> None:
        self.step = parameters.horizon_step
        self._compiled = parameters
        self._flown = _About(parameters)
        self._next = self._flown
        self.solver = make_solver(self._flown.problem, parameters)
        self.decrease = self._flown.decrease
        self._target = np.full(3, np.nan)

    def check(self, parameters: PaperParameters) -> None:
        """See :meth:`Formulation.check`.

        Raises:
            ParameterError: A weight or bound differs, or there is no terminal controller for this
                orbit.
        """
        when = f"in flight unless terminal_constraint is {ARTIFICIAL_ORBIT!r}"
        refuse_fixed(self._compiled, parameters, when, COMPILED)
        if parameters.orbit != self._next.orbit:
            self._next = _About(parameters)

    def change(self, parameters: PaperParameters) -> None:
        """Take a new orbit, with its terminal ingredients, and a new time budget.

        Args:
            parameters: The new ones.

        Raises:
            ParameterError: As of :meth:`check`; nothing has changed.
        """
        self.check(parameters)
        if parameters.orbit != self._flown.orbit:
            self._flown, self.decrease = self._next, self._next.decrease.after(self.decrease)
            self.solver.change(self._flown.problem)
        self.solver.time_limit = parameters.solve_time_max

    def soften(self, factors: NDArray[np.float64]) -> None:
        """See :meth:`Formulation.soften`: the paper's cost knows no rates of inputs."""

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
