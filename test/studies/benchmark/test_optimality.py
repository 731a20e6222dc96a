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

"""Cost and KKT residual of plans, against problems whose solutions are known."""

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem
from uav_tracking_mpc.studies.benchmark.optimality import OptimalityMeasure


def integrator(**more):
    """Min sum u^2 + (x_2 - 1)^2 with x+ = x + u from 0 in two steps: u = 1/4 each."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    return OptimalControlProblem(
        state=x,
        inputs=u,
        next_state=x + u,
        stage_cost=u**2 / 2.0,
        terminal_cost=(x - 1.0) ** 2,
        horizon=2,
        step=1.0,
        input_lower=np.array([-2.0]),
        input_upper=np.array([2.0]),
        **{name: make(x) for name, make in more.items()},
    )


def measured(problem, inputs):
    return OptimalityMeasure(problem)(np.zeros(1), np.array([inputs]).T, np.zeros(0))


def test_an_optimal_plan_has_no_residual_and_another_has_its_gradient():
    cost, residual, violation = measured(integrator(), [0.4, 0.4])
    assert cost == pytest.approx(0.16 + 0.04)
    assert residual < 1e-15
    assert violation == 0.0
    _, residual, _ = measured(integrator(), [0.0, 0.0])  # the gradient is -2 in both
    assert residual == pytest.approx(2.0 / 3.0)


def test_a_bound_holds_what_the_gradient_pushes_against_it():
    assert measured(integrator(), [2.0, 2.0])[1] > 0.5  # pushed away from it
    problem = integrator(terminal_inequalities=lambda x: (Inequality(x - 0.5),))
    _, residual, violation = measured(problem, [0.25, 0.25])
    assert residual < 1e-12
    assert violation < 1e-12
    assert measured(problem, [0.4, 0.4])[2] == pytest.approx(0.3)


def test_a_soft_constraint_costs_its_penalty_and_pushes_with_it():
    problem = integrator(terminal_inequalities=lambda x: (Inequality(x - 0.5, penalty=0.1),))
    # u + 2 (2 u - 1) + 0.1 = 0
    optimal = 1.9 / 5.0
    cost, residual, violation = measured(problem, [optimal, optimal])
    assert cost == pytest.approx(optimal**2 + (2 * optimal - 1) ** 2 + 0.1 * (2 * optimal - 0.5))
    assert residual < 1e-12
    assert violation == 0.0


def test_an_equality_holds_and_is_missed_by_its_value():
    problem = integrator(terminal_equality=lambda x: x - 2.0)
    assert measured(problem, [1.0, 1.0])[1:] == (pytest.approx(0.0, abs=1e-12), 0.0)
    assert measured(problem, [1.0, 0.5])[2] == pytest.approx(0.5)


def test_a_plan_without_values_is_no_plan():
    assert measured(integrator(), [np.nan, 0.0]) == (np.inf, np.inf, np.inf)


def test_the_cost_of_one_stage():
    problem = integrator(stage_inequalities=lambda x: (Inequality(x - 1.0, penalty=3.0),))
    cost, following = OptimalityMeasure(problem).stage_cost(
        np.array([2.0]), np.array([0.5]), np.zeros(0), np.zeros(0)
    )
    assert cost == pytest.approx(0.125 + 3.0)
    assert following == pytest.approx([2.5])
