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

"""The problem as a nonlinear program.

Multiple shooting with the variables stage by stage, [x_i, a_i, u_i, s_i] for i < N and
[x_N, a_N, s_N] at the end: a is carried as a state with a_{i+1} = a_i, s >= 0 are the violations of
the soft inequalities. fatrop exploits exactly this order; IPOPT takes any.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem


class NonlinearProgram:
    """Variables, bounds and constraints of the nonlinear program, stage by stage.

    Args:
        problem: What is solved.

    Attributes:
        nlp: The program as CasADi's ``nlpsol`` takes it.
        lower: Least values of the variables.
        upper: Greatest values of the variables.
        constraint_lower: Least values of the constraints; the greatest are 0.
        equality: Which constraints are equalities.
        nx: Variables of each stage that are states, for fatrop.
        nu: Those that are inputs, for fatrop.
        ng: Constraints of each stage but for the dynamics, for fatrop.
    """

    def __init__(self, problem: OptimalControlProblem) -> None:
        self.problem = problem
        x, u, p, a = problem.state, problem.inputs, problem.parameter, problem.decision
        n, nx, nu, na = problem.horizon, problem.nx, problem.nu, problem.na
        stage_hard, stage_soft, stage_penalty = hard_and_soft(problem.stage_inequalities)
        end_hard, end_soft, end_penalty = hard_and_soft(problem.terminal_inequalities)
        soft = stage_soft.numel()
        stage = ca.Function(
            "stage", [x, u, p, a], [problem.next_state, problem.stage_cost, stage_hard, stage_soft]
        )
        end = ca.Function(
            "end", [x, p, a], [problem.terminal_cost, problem.terminal_equality, end_hard, end_soft]
        )
        initial = ca.SX.sym("initial", nx)
        values = ca.SX.sym("p", problem.np, n + 1)

        variables: list[ca.SX] = []
        constraints, equality = [], []
        cost = ca.SX(0)
        self.ng = []
        xs = [ca.SX.sym(f"x{i}", nx) for i in range(n + 1)]
        decisions = [ca.SX.sym(f"a{i}", na) for i in range(n + 1)]

        def constrain(expression: ca.SX, is_equality: bool) -> int:
            constraints.append(expression)
            equality.extend([is_equality] * expression.numel())
            return int(expression.numel())

        for i in range(n):
            ui, si = ca.SX.sym(f"u{i}", nu), ca.SX.sym(f"s{i}", soft)
            variables += [xs[i], decisions[i], ui, si]
            following, stage_cost, hard, soft_value = stage(xs[i], ui, values[:, i], decisions[i])
            cost += stage_cost + ca.dot(stage_penalty, si)
            constrain(xs[i + 1] - following, True)  # (16b)
            constrain(decisions[i + 1] - decisions[i], True)
            count = constrain(xs[0] - initial, True) if i == 0 else 0
            count += constrain(hard, False) + constrain(soft_value - si, False)
            self.ng.append(count)
        s_end = ca.SX.sym("s_end", end_soft.numel())
        variables += [xs[n], decisions[n], s_end]
        end_cost, end_equal, hard, soft_value = end(xs[n], values[:, n], decisions[n])
        cost += end_cost + ca.dot(end_penalty, s_end)
        count = constrain(end_equal, True)
        count += constrain(hard, False) + constrain(soft_value - s_end, False)  # (16e)
        self.ng.append(count)

        self._stage = stage
        self.nx = [nx + na] * (n + 1)
        self.nu = [nu + soft] * n + [s_end.numel()]
        self.equality = equality
        self.constraint_lower = np.where(equality, 0.0, -np.inf)
        self.nlp = {
            "x": ca.vertcat(*variables),
            "f": cost,
            "g": ca.vertcat(*constraints),
            "p": ca.vertcat(initial, ca.vec(values)),
        }
        self._stage_size, self._soft = nx + na + nu + soft, (soft, s_end.numel())
        self.bound(problem)

    def bound(self, problem: OptimalControlProblem) -> None:
        """Take the bounds of the variables from a problem.

        Args:
            problem: Of the same expressions.
        """
        soft, soft_end = self._soft
        bounds = []
        for sign, decision, inputs, violation in (
            (-1.0, problem.decision_lower, problem.input_lower, 0.0),
            (1.0, problem.decision_upper, problem.input_upper, np.inf),
        ):
            state = np.full(problem.nx, sign * np.inf)
            stage = np.concatenate([state, decision, inputs, np.full(soft, violation)])
            end = [state, decision, np.full(soft_end, violation)]
            bounds.append(np.concatenate([np.tile(stage, problem.horizon), *end]))
        self.lower, self.upper = bounds

    def rollout(
        self,
        x_0: NDArray[np.float64],
        inputs: NDArray[np.float64],
        p: NDArray[np.float64],
        decision: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """States under given inputs; x_0 throughout where they are not finite.

        Args:
            x_0: State of stage 0, shape (nx,).
            inputs: u_0..u_{N-1}, shape (N, nu).
            p: Parameters of stages 0..N, shape (N + 1, np).
            decision: a, shape (na,).

        Returns:
            x_0..x_N, shape (N + 1, nx).
        """
        states = [x_0]
        for u, parameter in zip(inputs, p, strict=False):
            following = self._stage(states[-1], u, parameter, decision)[0]
            states.append(np.array(following).ravel())
        rolled = np.array(states)
        return rolled if np.isfinite(rolled).all() else np.tile(x_0, (len(states), 1))

    def pack(
        self,
        states: NDArray[np.float64],
        inputs: NDArray[np.float64],
        decision: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Variables of the program from a plan; slacks start at 0.

        Args:
            states: x_0..x_N, shape (N + 1, nx).
            inputs: u_0..u_{N-1}, shape (N, nu).
            decision: a, shape (na,).

        Returns:
            All variables, shape (n,).
        """
        nx, nu, na, n = self.problem.nx, self.problem.nu, self.problem.na, self.problem.horizon
        variables = np.zeros(len(self.lower))
        stages = variables[: n * self._stage_size].reshape(n, self._stage_size)
        stages[:, :nx] = states[:n]
        stages[:, nx : nx + na] = decision
        stages[:, nx + na : nx + na + nu] = inputs
        end = variables[n * self._stage_size :]
        end[:nx] = states[n]
        end[nx : nx + na] = decision
        return variables

    def unpack(
        self, variables: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Plan (states, inputs, decision) from the variables of the program.

        Args:
            variables: Of all stages, shape (n,).

        Returns:
            x_0..x_N, shape (N + 1, nx); u_0..u_{N-1}, shape (N, nu); and a, shape (na,).
        """
        nx, nu, na, n = self.problem.nx, self.problem.nu, self.problem.na, self.problem.horizon
        stages = variables[: n * self._stage_size].reshape(n, self._stage_size)
        end = variables[n * self._stage_size :]
        states = np.vstack([stages[:, :nx], end[:nx]])
        return states, stages[:, nx + na : nx + na + nu].copy(), stages[0, nx : nx + na].copy()


def hard_and_soft(inequalities: tuple[Inequality, ...]) -> tuple[ca.SX, ca.SX, ca.DM]:
    """Hard expressions, soft expressions, and the penalty of each row of the soft ones.

    Args:
        inequalities: At a stage, or at the end.
    """
    hard = ca.vertcat(ca.SX.zeros(0, 1), *(h.expression for h in inequalities if h.penalty is None))
    soft = [h for h in inequalities if h.penalty is not None]
    expressions = ca.vertcat(ca.SX.zeros(0, 1), *(h.expression for h in soft))
    penalties = [h.penalty for h in soft for _ in range(h.expression.numel())]
    return hard, expressions, ca.DM(np.array(penalties, dtype=float).reshape(-1, 1))
