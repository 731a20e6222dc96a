"""The tracking problem: model, orbit and weights put together as an optimal control problem."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.dynamics.discretisation import error_dynamics, linearise
from uav_tracking_mpc.guidance.tracking_parameters import TrackingParameters
from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.quadratic import TerminalSet, quadratic_problem
from uav_tracking_mpc.stability.terminal import input_limited_level, terminal_ingredients


def tracking_problem(parameters: TrackingParameters) -> OptimalControlProblem:
    """P_N(x_0), (16), in tracking errors x = xbar - x_ss, u = ubar - u_ss.

    The terminal set, when asked for, is X_f of (25): as large as U allows.

    Raises:
        ValueError: No stabilising terminal controller for this orbit and these weights.
    """
    dynamics = error_dynamics(
        parameters.model, parameters.orbit, parameters.horizon_step, parameters.scheme
    )
    state_weight = np.diag(parameters.state_weights)
    input_weight = np.diag(parameters.input_weights)
    ingredients = terminal_ingredients(
        *linearise(dynamics), state_weight, input_weight, parameters.terminal_scaling
    )
    u_ss = parameters.steady_inputs
    lower, upper = parameters.input_lower - u_ss, parameters.input_upper - u_ss
    terminal_set = None
    if parameters.terminal_constraint != "none":
        penalty = parameters.terminal_penalty if parameters.terminal_constraint == "soft" else None
        terminal_set = TerminalSet(input_limited_level(ingredients, lower, upper), penalty)
    return quadratic_problem(
        dynamics,
        horizon=parameters.horizon,
        step=parameters.horizon_step,
        state_weight=state_weight,
        input_weight=input_weight,
        terminal_weight=ingredients.weight,
        input_lower=lower,
        input_upper=upper,
        terminal_set=terminal_set,
    )
