"""P_N of (16) for a configuration of the analysis, and who solves it."""

from __future__ import annotations

from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.quadratic import TerminalSet, quadratic_problem
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem


def tracking_problem(
    problem: StabilityProblem, level: float | None, penalty: float | None = None
) -> OptimalControlProblem:
    """(14)-(16) in tracking errors x = xbar - x_ss, u = ubar - u_ss.

    Args:
        problem: The configuration.
        level: varrho of the terminal set (16e); None leaves it away.
        penalty: None to enforce the terminal set; else the L1 weight of a violation.
    """
    lower, upper = problem.deviation_bounds()
    return quadratic_problem(
        problem.dynamics(),
        horizon=problem.horizon,
        step=problem.step,
        state_weight=problem.state_weight,
        input_weight=problem.input_weight,
        terminal_weight=problem.ingredients().weight,
        input_lower=lower,
        input_upper=upper,
        terminal_set=None if level is None else TerminalSet(level, penalty),
    )
