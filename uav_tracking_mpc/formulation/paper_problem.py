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

"""The paper's problem (14)-(16): for a configuration of the analysis, and for parameters."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.dynamics.discretisation import orbit_dynamics, orbit_numbers
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.quadratic import TerminalSet, quadratic_problem
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.terminal.ingredients import input_limited_level
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem

# At the very limit rounding decides whether K x is in U, and no proof closes.
LEVEL_MARGIN = 1.0 - 2e-6


def stability_problem(parameters: TrackingParameters, name: str = "unnamed") -> StabilityProblem:
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


def terminal_level(
    parameters: TrackingParameters, problem: StabilityProblem | None = None
) -> float | None:
    """Varrho of X_f (25), as large as U allows; None where no terminal set is asked for.

    Args:
        parameters: What is flown.
        problem: Of these parameters; made from them by default.
    """
    if parameters.terminal_constraint == "none":
        return None
    problem = problem or stability_problem(parameters)
    return LEVEL_MARGIN * input_limited_level(problem.ingredients(), *problem.deviation_bounds())


def problem_of(
    parameters: TrackingParameters, problem: StabilityProblem | None = None
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
