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

"""Problems for the solver's tests: one of each kind, small enough to compile in seconds."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np

from uav_tracking_mpc.dynamics import paper_numbers
from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.formulation.paper_formulation import tracking_problem
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem
from uav_tracking_mpc.mpc.solver import Solution
from uav_tracking_mpc.studies.benchmark.optimality import OptimalityMeasure
from uav_tracking_mpc.terminal.ingredients import input_limited_level, paper_problem

PAPER_START = tracking_error(paper_numbers.INITIAL_STATE, paper_numbers.ORBIT)


def integrator(**changes):
    """A double integrator to the origin."""
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
    data = {
        "state": x,
        "inputs": u,
        "next_state": ca.vertcat(x[0] + 0.1 * x[1], x[1] + 0.1 * u),
        "stage_cost": ca.sumsqr(x) + ca.sumsqr(u),
        "terminal_cost": ca.sumsqr(x),
        "horizon": 10,
        "step": 0.1,
        "input_lower": np.array([-1.0]),
        "input_upper": np.array([1.0]),
    }
    data.update({key: value(x, u) if callable(value) else value for key, value in changes.items()})
    return OptimalControlProblem(**data)


def pendulum(
    *, horizon: int = 12, speed_penalty: float | None = None, reach: float = 0.4
) -> OptimalControlProblem:
    """A driven pendulum with everything that a problem may have.

    x = (angle, rate), u = torque; p pushes the rate; a is the angle at which it is to rest, paid
    for by its distance to ``reach``; the rate is limited at the stages (hard or soft), as is
    u - 2 angle; at the end it rests at a, and a is inside a disc. What holds it there is its
    continuation.
    """
    x, u = ca.SX.sym("x", 2), ca.SX.sym("u", 1)
    p, a = ca.SX.sym("p", 1), ca.SX.sym("a", 1)
    step = 0.2
    rate = x[1] + step * (u - ca.sin(x[0]) - 0.1 * x[1] + p)
    return OptimalControlProblem(
        state=x,
        inputs=u,
        next_state=ca.vertcat(x[0] + step * x[1], rate),
        stage_cost=(x[0] - a) ** 2 + 0.1 * x[1] ** 2 + 0.05 * u**2,
        terminal_cost=5.0 * (a - reach) ** 2,
        horizon=horizon,
        step=step,
        input_lower=np.array([-2.0]),
        input_upper=np.array([1.5]),
        parameter=p,
        decision=a,
        decision_lower=np.array([-1.0]),
        decision_upper=np.array([1.0]),
        decision_guess=np.array([0.0]),
        stage_inequalities=(
            Inequality(ca.vertcat(x[1] - 0.5, -0.9 - x[1]), speed_penalty, "rate"),
            Inequality(u - 2.0 * x[0] - 2.2, None, "coupled"),
        ),
        terminal_inequalities=(Inequality(a**2 - 0.09, None, "disc"),),
        terminal_equality=ca.vertcat(x[0] - a, x[1]),
        continuation=ca.sin(x[0]) - p,
    )


@lru_cache
def paper(horizon: int = 10, ellipsoid: bool = False) -> OptimalControlProblem:
    """The paper's problem, with X_f as a soft constraint or without."""
    problem = paper_problem(horizon=horizon)
    level = input_limited_level(problem.ingredients(), *problem.deviation_bounds())
    return tracking_problem(problem, level if ellipsoid else None, penalty=100.0)


@lru_cache
def paper_solver() -> NewtonSolver:
    """One solver for all tests that only read the plain problem; reset it first."""
    return NewtonSolver(paper())


def kkt_residual(
    problem: OptimalControlProblem, solution: Solution, x_0: np.ndarray, p: np.ndarray | None = None
) -> float:
    """Smallest stationarity residual over all multipliers that the active constraints allow."""
    return OptimalityMeasure(problem)(x_0, solution.inputs, solution.decision, p)[1]
