"""How far can be flown at all in N steps? Where that is too little, P_N is surely infeasible."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.stability_problem import StabilityProblem


def distance_budget(
    problem: StabilityProblem, state: NDArray[np.float64], level: float
) -> tuple[float, float]:
    """Range to cover to reach X_f, and an upper bound for what can be flown in N steps.

    Each Euler step changes r by at most T_s v, and v is limited by the acceleration from the start
    and by the speeds that X_f holds at the end.

    Args:
        problem: Horizon, step, input bounds, weights.
        state: (r, theta, z, chi, v), shape (5,).
        level: varrho [-].

    Returns:
        (needed, possible), in [m]. needed > possible proves that (16e) is infeasible.
    """
    inverse = np.linalg.inv(problem.ingredients().weight)
    extent = np.sqrt(level * np.diag(inverse))
    needed = abs(float(state[0]) - problem.orbit.range) - float(extent[0])
    k = np.arange(problem.horizon)
    up, down = problem.step * problem.input_upper[2], -problem.step * problem.input_lower[2]
    last = problem.orbit.speed + float(extent[4])
    speeds = np.minimum(state[4] + k * up, last + (problem.horizon - k) * down)
    return needed, float(problem.step * np.maximum(speeds, 0.0).sum())
