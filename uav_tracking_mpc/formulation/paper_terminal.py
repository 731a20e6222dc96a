"""The tracking problem: what the parameters ask for, as the analysis and the solvers take it."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.formulation.paper_problem import tracking_problem as problem_of
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.terminal.ingredients import input_limited_level
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem

# At the very limit rounding decides whether K x is in U, and no proof closes.
LEVEL_MARGIN = 1.0 - 2e-6


def stability_problem(parameters: TrackingParameters, name: str = "unnamed") -> StabilityProblem:
    """Orbit, model, weights and input set of the parameters."""
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


def terminal_level(parameters: TrackingParameters) -> float | None:
    """Varrho of X_f (25), as large as U allows; None where no terminal set is asked for."""
    if parameters.terminal_constraint == "none":
        return None
    problem = stability_problem(parameters)
    return LEVEL_MARGIN * input_limited_level(problem.ingredients(), *problem.deviation_bounds())


def tracking_problem(parameters: TrackingParameters) -> OptimalControlProblem:
    """P_N(x_0), (16), of the parameters.

    Raises:
        ParameterError: No stabilising terminal controller for this orbit and these weights.
    """
    penalty = parameters.terminal_penalty if parameters.terminal_constraint == "soft" else None
    try:
        return problem_of(stability_problem(parameters), terminal_level(parameters), penalty)
    except (ValueError, np.linalg.LinAlgError) as error:
        raise ParameterError(
            "parameters 'state_weights', 'input_weights', 'terminal_scaling' and the orbit give no "
            f"problem that can be solved: {error}"
        ) from error
