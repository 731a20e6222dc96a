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

"""How optimal a plan is, whoever found it: measured from the problem's expressions alone.

A plan is its inputs and decisions z = (u_0..u_{N-1}, a); the dynamics are rolled out. The
multipliers come from non-negative least squares over the constraints that are active, not from a
solver, so plans of different solvers are measured alike.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem

ACTIVE = 1e-5  # -, tolerance: an inequality this close to 0 counts as active
AT_BOUND = 1e-6  # -, tolerance of a bound of inputs or decisions: interior points end inside of it


class OptimalityMeasure:
    """The measure for one problem.

    Args:
        problem: Whose plans are measured.
    """

    def __init__(self, problem: OptimalControlProblem) -> None:
        self.problem = problem
        symbols = [problem.state, problem.inputs, problem.parameter, problem.decision]
        known = ca.vertcat(problem.state, problem.inputs, problem.decision)
        stage = ca.vertcat(problem.stage_cost, _column(problem.stage_inequalities))
        end = ca.vertcat(
            problem.terminal_cost, _column(problem.terminal_inequalities), problem.terminal_equality
        )
        following = problem.next_state
        self._stage = ca.Function(
            "stage",
            symbols,
            [following, stage, ca.jacobian(following, known), ca.jacobian(stage, known)],
        )
        self._end = ca.Function("end", symbols, [end, ca.jacobian(end, known)])
        self._stage_penalties = _penalties(problem.stage_inequalities)
        self._end_penalties = _penalties(problem.terminal_inequalities)

    def stage_cost(
        self,
        state: NDArray[np.float64],
        inputs: NDArray[np.float64],
        decision: NDArray[np.float64],
        parameters: NDArray[np.float64],
    ) -> tuple[float, NDArray[np.float64]]:
        """Cost of one stage with its penalties [-], and the state after it, shape (nx,).

        Args:
            state: x, shape (nx,).
            inputs: u, shape (nu,).
            decision: a, shape (na,).
            parameters: p of the stage, shape (np,).
        """
        following, values, *_ = self._stage(state, inputs, parameters, decision)
        numbers = _vector(values)
        cost = numbers[0] + _penalty(numbers[1:], self._stage_penalties)
        return float(cost), _vector(following)

    def __call__(
        self,
        initial_state: NDArray[np.float64],
        inputs: NDArray[np.float64],
        decision: NDArray[np.float64],
        parameters: NDArray[np.float64] | None = None,
    ) -> tuple[float, float, float]:
        """Cost, KKT residual and violation of a plan.

        Args:
            initial_state: x_0, shape (nx,).
            inputs: u_0..u_{N-1}, shape (N, nu).
            decision: a, shape (na,).
            parameters: p_0..p_N, shape (N + 1, np), or (np,) where they do not change; the
                problem's usual one by default.

        Returns:
            Cost with the penalties of soft constraints [-]; stationarity relative to 1 + the
            largest component of the gradient [-]; largest violation of a hard constraint, in its
            own units [-]. All infinite where the plan has no finite values.
        """
        problem = self.problem
        n, nx, nu, na = problem.horizon, problem.nx, problem.nu, problem.na
        p = np.zeros((n + 1, problem.np))
        p[:] = problem.usual_parameter if parameters is None else parameters
        size = n * nu + na
        state, slope = np.asarray(initial_state, dtype=float), np.zeros((nx, size))
        cost, gradient = 0.0, np.zeros(size)
        values, rows = [], []
        rest = np.zeros((nu + na, size))
        rest[nu:, n * nu :] = np.eye(na)
        for i in range(n):
            whole = np.vstack([slope, rest])
            whole[nx : nx + nu, i * nu : (i + 1) * nu] = np.eye(nu)
            answers = self._stage(state, inputs[i], p[i], decision)
            following, stage, next_slope, stage_slope = (np.array(part) for part in answers)
            stage, row = stage.ravel(), stage_slope @ whole
            cost, gradient = cost + stage[0], gradient + row[0]
            values.append(stage[1:])
            rows.append(row[1:])
            state, slope = following.ravel(), next_slope @ whole
        end, end_slope = self._end(state, np.zeros(nu), p[n], decision)
        end, row = _vector(end), np.array(end_slope) @ np.vstack([slope, rest])
        cost, gradient = cost + end[0], gradient + row[0]
        count = 1 + len(self._end_penalties)
        c, jacobian = np.concatenate([*values, end[1:count]]), np.vstack([*rows, row[1:count]])
        penalties = np.concatenate([np.tile(self._stage_penalties, n), self._end_penalties])
        parts = (gradient, c, jacobian, row[count:])
        if not all(np.all(np.isfinite(part)) for part in parts):
            return np.inf, np.inf, np.inf
        hard = c[~np.isfinite(penalties)]
        violation = float(max(np.max(hard, initial=0.0), np.max(np.abs(end[count:]), initial=0.0)))
        point = np.concatenate([np.ravel(inputs), decision])
        return (
            float(cost + _penalty(c, penalties)),
            self._stationarity(point, gradient, c, jacobian, row[count:], penalties),
            violation,
        )

    def _stationarity(
        self,
        point: NDArray[np.float64],
        gradient: NDArray[np.float64],
        c: NDArray[np.float64],
        jacobian: NDArray[np.float64],
        equal: NDArray[np.float64],
        penalties: NDArray[np.float64],
    ) -> float:
        """Smallest over all multipliers that the active constraints allow."""
        problem = self.problem
        violated = np.isfinite(penalties) & (c > ACTIVE)
        gradient = gradient + penalties[violated] @ jacobian[violated]
        lower = np.concatenate(
            [np.tile(problem.input_lower, problem.horizon), problem.decision_lower]
        )
        upper = np.concatenate(
            [np.tile(problem.input_upper, problem.horizon), problem.decision_upper]
        )
        unit = np.eye(len(point))
        matrix = np.hstack(
            [
                equal.T,
                -equal.T,
                jacobian[~violated & (np.abs(c) <= ACTIVE)].T,
                -unit[:, point <= lower + AT_BOUND],
                unit[:, point >= upper - AT_BOUND],
            ]
        )
        scale = 1.0 + np.abs(gradient).max()
        if matrix.shape[1] == 0:
            return float(np.abs(gradient).max() / scale)
        multipliers, _ = nnls(matrix, -gradient, maxiter=10000)
        return float(np.abs(gradient + matrix @ multipliers).max() / scale)


def _vector(value: ca.DM) -> NDArray[np.float64]:
    return np.array(value).ravel()


def _column(inequalities: tuple[Inequality, ...]) -> ca.SX:
    return ca.vertcat(ca.SX(0, 1), *(h.expression for h in inequalities))


def _penalty(values: NDArray[np.float64], penalties: NDArray[np.float64]) -> float:
    soft = np.isfinite(penalties)
    return float(penalties[soft] @ np.maximum(values[soft], 0.0))


def _penalties(inequalities: tuple[Inequality, ...]) -> NDArray[np.float64]:
    """Of each row; infinite for a hard constraint."""
    return np.array(
        [
            np.inf if h.penalty is None else h.penalty
            for h in inequalities
            for _ in range(h.expression.numel())
        ]
    )
