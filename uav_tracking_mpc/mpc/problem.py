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

r"""An optimal control problem over a finite horizon, as data.

.. math::

    \min_{u_0..u_{N-1},\,a} \; \sum_{i=0}^{N-1} l(x_i, u_i, p_i, a) + V_f(x_N, p_N, a)

subject to x_0 given, x_{i+1} = f(x_i, u_i, p_i, a), u_i in a box, h(x_i, u_i, p_i, a) <= 0 at the
stages, h_N(x_N, p_N, a) <= 0 and e_N(x_N, p_N, a) = 0 at the end. p_i are parameters known in
advance that may differ from stage to stage; a are a few decisions that are constant over the
horizon. An inequality is hard, or soft with an exact (L1) penalty. (14)-(16) of the paper is the
case without a and h, quadratic in the tracking error, with a terminal ellipsoid. What depends on
its reference are values of p, not of expressions: those of the dynamics, P_rho by its upper
triangle, and the level of the terminal set. So a solver that is compiled for one reference solves
the problem of every other.

All expressions are CasADi SX in the problem's own symbols, so solvers derive what they need.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Inequality:
    """``expression <= 0``, elementwise.

    Attributes:
        expression: SX column in the symbols of the problem.
        penalty: None for a hard constraint; for a soft one the weight of the violation in the
            cost [-], ``penalty * sum(max(0, expression))``: exact once it exceeds the multipliers.
        name: What a message calls it.
    """

    expression: ca.SX
    penalty: float | None = None
    name: str = "constraint"

    def __post_init__(self) -> None:
        """Refuse a penalty that penalises nothing."""
        if self.penalty is not None and not (np.isfinite(self.penalty) and self.penalty > 0.0):
            raise ValueError(
                f"penalty of {self.name!r} is {self.penalty}, must be positive and finite, "
                "or None for a hard constraint"
            )


def _no_symbols() -> ca.SX:
    return ca.SX.zeros(0, 1)


@dataclass(frozen=True)
class OptimalControlProblem:
    """The problem of the module's docstring.

    Attributes:
        state: x, SX symbol (nx, 1).
        inputs: u, SX symbol (nu, 1).
        next_state: f, SX (nx, 1).
        stage_cost: l, SX (1, 1).
        terminal_cost: V_f, SX (1, 1), free of u.
        horizon: N, number of stages.
        step: T_s, time from stage to stage in [s]; solvers use it to shift warm starts.
        input_lower: Lower bounds of u, shape (nu,).
        input_upper: Upper bounds of u, shape (nu,).
        parameter: p, SX symbol (np, 1), values given per stage 0..N at each solve.
        parameter_values: p of every stage where a solve is given none, shape (np,), 0 by default.
        decision: a, SX symbol (na, 1), free but constant over the horizon.
        decision_lower: Lower bounds of a, shape (na,).
        decision_upper: Upper bounds of a, shape (na,).
        decision_guess: Where a cold start places a, shape (na,).
        state_goal: Where the cost wants the state, shape (nx,), the origin by default; a cold
            start also tries a plan that rests there.
        stage_inequalities: h, at stages 0..N-1.
        terminal_inequalities: h_N, free of u.
        terminal_equality: e_N, SX (ne, 1), free of u.
        continuation: Input after the horizon, SX (nu, 1) in x = x_N, u = u_{N-1}, p_N and a: the
            terminal control law, with which a warm start ends; u_{N-1} held by default.
    """

    state: ca.SX
    inputs: ca.SX
    next_state: ca.SX
    stage_cost: ca.SX
    terminal_cost: ca.SX
    horizon: int
    step: float
    input_lower: NDArray[np.float64]
    input_upper: NDArray[np.float64]
    parameter: ca.SX = field(default_factory=_no_symbols)
    parameter_values: NDArray[np.float64] | None = None
    decision: ca.SX = field(default_factory=_no_symbols)
    decision_lower: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    decision_upper: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    decision_guess: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    state_goal: NDArray[np.float64] | None = None
    stage_inequalities: tuple[Inequality, ...] = ()
    terminal_inequalities: tuple[Inequality, ...] = ()
    terminal_equality: ca.SX = field(default_factory=_no_symbols)
    continuation: ca.SX | None = None

    def __post_init__(self) -> None:
        """Check sizes and bounds once, where the problem is built."""
        if self.horizon < 1:
            raise ValueError(f"horizon is {self.horizon}, must be at least 1")
        if not (np.isfinite(self.step) and self.step > 0.0):
            raise ValueError(f"step is {self.step} s, must be positive and finite")
        if self.next_state.shape != self.state.shape:
            raise ValueError(
                f"next_state has shape {self.next_state.shape}, must be {self.state.shape}"
            )
        if self.continuation is not None and self.continuation.shape != self.inputs.shape:
            raise ValueError(
                f"continuation has shape {self.continuation.shape}, must be {self.inputs.shape}"
            )
        for name, size in (("input", self.nu), ("decision", self.na)):
            lower = np.asarray(getattr(self, f"{name}_lower"), dtype=float)
            upper = np.asarray(getattr(self, f"{name}_upper"), dtype=float)
            if lower.shape != (size,) or upper.shape != (size,):
                raise ValueError(
                    f"{name} bounds have shapes {lower.shape} and {upper.shape}, must be ({size},)"
                )
            if not np.all(lower < upper):
                raise ValueError(
                    f"{name} bounds are {lower} and {upper}: lower must be below upper"
                )
        values = self.parameter_values
        if values is not None and np.shape(values) != (self.np,):
            raise ValueError(f"parameter_values has shape {np.shape(values)}, must be ({self.np},)")
        if np.shape(self.decision_guess) != (self.na,):
            raise ValueError(
                f"decision_guess has shape {np.shape(self.decision_guess)}, must be ({self.na},)"
            )
        terminal = ca.vertcat(
            self.terminal_cost,
            self.terminal_equality,
            *(h.expression for h in self.terminal_inequalities),
        )
        if ca.depends_on(terminal, self.inputs):
            raise ValueError("terminal cost and constraints must not depend on the inputs")

    @property
    def input_rest(self) -> NDArray[np.float64]:
        """The inputs of the box that are nearest to 0, shape (nu,)."""
        return np.clip(np.zeros(self.nu), self.input_lower, self.input_upper)

    @property
    def usual_parameter(self) -> NDArray[np.float64]:
        """The p of every stage where a solve is given none, shape (np,)."""
        return np.zeros(self.np) if self.parameter_values is None else self.parameter_values

    @property
    def nx(self) -> int:
        """Number of states."""
        return self.state.numel()

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return self.inputs.numel()

    @property
    def np(self) -> int:
        """Number of parameters per stage."""
        return self.parameter.numel()

    @property
    def na(self) -> int:
        """Number of decisions constant over the horizon."""
        return self.decision.numel()


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
    symmetric = ca.tril2symm(ca.SX(ca.Sparsity.lower(nx), p_rho))  # by columns: of the upper, rows
    level = ca.SX.sym("level")
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


def _check_positive_definite(name: str, weight: NDArray[np.float64], size: int) -> None:
    if weight.shape != (size, size):
        raise ValueError(f"{name} has shape {weight.shape}, must be ({size}, {size})")
    if not (np.all(np.isfinite(weight)) and np.allclose(weight, weight.T, rtol=1e-9)):
        raise ValueError(f"{name} must be finite and symmetric")
    smallest = float(np.linalg.eigvalsh(weight)[0])
    if smallest <= 0.0:
        raise ValueError(f"{name} has eigenvalue {smallest:.3g}, must be positive definite")
