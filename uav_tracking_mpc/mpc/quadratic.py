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

"""Problem (14)-(16) of the paper: quadratic costs in the tracking error, a terminal ellipsoid.

What depends on the reference are values of the problem's parameter p, not of its expressions: those
of the dynamics, P_rho by its upper triangle, and the level of the terminal set. So a solver that is
compiled for one reference solves the problem of every other.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem

TERMINAL_CONSTRAINTS = ("none", "soft", "hard")


@dataclass(frozen=True)
class TerminalSet:
    """X_f of (16e) and (25): x' P_rho x <= level.

    Attributes:
        level: varrho_x, positive [-].
        penalty: None to enforce it; else the L1 weight of a violation (soft) [-].
    """

    level: float
    penalty: float | None = None

    def __post_init__(self) -> None:
        """Refuse an empty set."""
        if not (np.isfinite(self.level) and self.level > 0.0):
            raise ValueError(f"terminal level is {self.level}, must be positive and finite")


def quadratic_problem(
    dynamics: ca.Function,
    *,
    horizon: int,
    step: float,
    state_weight: NDArray[np.float64],
    input_weight: NDArray[np.float64],
    terminal_weight: NDArray[np.float64],
    input_lower: NDArray[np.float64],
    input_upper: NDArray[np.float64],
    terminal_set: TerminalSet | None = None,
    reference: ArrayLike = (),
) -> OptimalControlProblem:
    """P_N of (16) with L(x, u) = |x|_Q^2 + |u|_R^2 and V_f(x) = |x|_{P_rho}^2, (14).

    Args:
        dynamics: f(x, u) of (10) in error coordinates, f(0, 0) = 0, or f(x, u, reference).
        horizon: N.
        step: T_s in [s].
        state_weight: Q, shape (nx, nx).
        input_weight: R, shape (nu, nu).
        terminal_weight: P_rho, shape (nx, nx).
        input_lower: Lower bounds of u (deviation from the steady inputs), shape (nu,).
        input_upper: Upper bounds of u, shape (nu,).
        terminal_set: X_f of (16e), or None.
        reference: What the dynamics depend on besides, shape (any,).

    Raises:
        ValueError: A weight is not symmetric positive definite, or sizes disagree.
    """
    nx, nu = dynamics.size1_in(0), dynamics.size1_in(1)
    weights = {
        "state_weight": (state_weight, nx),
        "input_weight": (input_weight, nu),
        "terminal_weight": (terminal_weight, nx),
    }
    for name, (weight, size) in weights.items():
        _check_positive_definite(name, np.asarray(weight, dtype=float), size)
    reference, levels = np.asarray(reference, dtype=float), []
    x, u, about = ca.SX.sym("x", nx), ca.SX.sym("u", nu), ca.SX.sym("reference", reference.size)
    p_rho = ca.SX.sym("P", nx * (nx + 1) // 2)
    symmetric, level = _symmetric(p_rho, nx), ca.SX.sym("level")
    terminal_cost = ca.bilin(symmetric, x, x)
    inequalities: tuple[Inequality, ...] = ()
    if terminal_set is not None:
        levels = [terminal_set.level]
        inequalities = (Inequality(terminal_cost - level, terminal_set.penalty, "terminal set"),)
    return OptimalControlProblem(
        state=x,
        inputs=u,
        next_state=dynamics(x, u, about) if reference.size else dynamics(x, u),
        stage_cost=ca.bilin(ca.DM(state_weight), x, x) + ca.bilin(ca.DM(input_weight), u, u),
        terminal_cost=terminal_cost,
        horizon=horizon,
        step=step,
        input_lower=np.asarray(input_lower, dtype=float),
        input_upper=np.asarray(input_upper, dtype=float),
        parameter=ca.vertcat(about, p_rho, level) if levels else ca.vertcat(about, p_rho),
        parameter_values=np.concatenate(
            [reference, np.asarray(terminal_weight, dtype=float)[np.triu_indices(nx)], levels]
        ),
        terminal_inequalities=inequalities,
    )


def _symmetric(upper: ca.SX, size: int) -> ca.SX:
    """Symmetric matrix of its upper triangle, row by row."""
    matrix, element = ca.SX(size, size), iter(ca.vertsplit(upper))
    for row in range(size):
        for column in range(row, size):
            matrix[row, column] = matrix[column, row] = next(element)
    return matrix


def _check_positive_definite(name: str, weight: NDArray[np.float64], size: int) -> None:
    if weight.shape != (size, size):
        raise ValueError(f"{name} has shape {weight.shape}, must be ({size}, {size})")
    if not (np.all(np.isfinite(weight)) and np.allclose(weight, weight.T, rtol=1e-9)):
        raise ValueError(f"{name} must be finite and symmetric")
    smallest = float(np.linalg.eigvalsh(weight)[0])
    if smallest <= 0.0:
        raise ValueError(f"{name} has eigenvalue {smallest:.3g}, must be positive definite")
