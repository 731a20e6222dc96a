"""KKT residual of a plan, evaluated by CasADi alone from the problem's expressions."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.optimize import nnls

from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution


def kkt_residual(
    problem: OptimalControlProblem, solution: Solution, x_0: np.ndarray, p: np.ndarray | None = None
) -> float:
    """Smallest stationarity residual over all multipliers that the active constraints allow.

    The plan is condensed onto z = (u, a) by rolling out the dynamics; soft constraints have their
    L1 subgradient. Multipliers come from non-negative least squares, not from the solver.
    """
    n, nu, na = problem.horizon, problem.nu, problem.na
    z = ca.SX.sym("z", n * nu + na)
    a = z[n * nu :]
    p = np.zeros(problem.np) if p is None else p
    symbols = [problem.state, problem.inputs, problem.parameter, problem.decision]
    h = ca.vertcat(ca.SX(0, 1), *(c.expression for c in problem.stage_inequalities))
    e = ca.vertcat(ca.SX(0, 1), *(c.expression for c in problem.terminal_inequalities))
    stage = ca.Function("s", symbols, [problem.next_state, problem.stage_cost, h])
    end = ca.Function("e", symbols, [problem.terminal_cost, e, problem.terminal_equality])
    x, cost, inequalities = ca.SX(x_0), 0, []
    for i in range(n):
        x, stage_cost, values = stage(x, z[i * nu : (i + 1) * nu], p, a)
        cost += stage_cost
        inequalities.append(values)
    end_cost, values, equality = end(x, np.zeros(nu), p, a)
    inequalities.append(values)
    inequality = ca.vertcat(*inequalities)
    cost += end_cost
    evaluate = ca.Function(
        "kkt",
        [z],
        [ca.gradient(cost, z), inequality, ca.jacobian(inequality, z), ca.jacobian(equality, z)],
    )
    point = np.concatenate([solution.inputs.ravel(), solution.decision])
    gradient, c, jacobian, equal = (np.array(part) for part in evaluate(point))
    gradient, c = gradient.ravel().copy(), c.ravel()
    stage_penalty = _penalties(problem.stage_inequalities)
    penalties = np.concatenate(
        [np.tile(stage_penalty, n), _penalties(problem.terminal_inequalities)]
    )
    columns = [equal.T, -equal.T]
    for value, row, penalty in zip(c, jacobian, penalties, strict=True):
        if np.isfinite(penalty) and value > 1e-5:
            gradient += penalty * row
        elif abs(value) <= 1e-5:
            columns.append(row[:, np.newaxis])
    lower = np.concatenate([np.tile(problem.input_lower, n), problem.decision_lower])
    upper = np.concatenate([np.tile(problem.input_upper, n), problem.decision_upper])
    for k in range(len(point)):
        unit = np.eye(len(point))[:, [k]]
        if point[k] <= lower[k] + 1e-9:
            columns.append(-unit)
        if point[k] >= upper[k] - 1e-9:
            columns.append(unit)
    matrix = np.hstack(columns) if columns else np.zeros((len(point), 0))
    scale = 1.0 + np.abs(gradient).max()
    if matrix.shape[1] == 0:
        return float(np.abs(gradient).max() / scale)
    multipliers, _ = nnls(matrix, -gradient, maxiter=10000)
    return float(np.abs(gradient + matrix @ multipliers).max() / scale)


def _penalties(inequalities) -> np.ndarray:
    return np.array(
        [
            np.inf if c.penalty is None else c.penalty
            for c in inequalities
            for _ in range(c.expression.numel())
        ]
    )
