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


import casadi as ca
import numpy as np
import pytest
from solver_problems import integrator

from uav_tracking_mpc.dynamics.relative import error_dynamics
from uav_tracking_mpc.mpc.problem import Inequality, TerminalSet, quadratic_problem


def test_sizes_are_those_of_the_symbols():
    problem = integrator()
    assert (problem.nx, problem.nu, problem.np, problem.na) == (2, 1, 0, 0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"horizon": 0}, "horizon is 0"),
        ({"step": 0.0}, "step is 0.0"),
        ({"step": np.nan}, "step is nan"),
        ({"input_lower": np.array([1.0])}, "lower must be below upper"),
        ({"input_lower": np.array([-1.0, -1.0])}, "shapes"),
        ({"input_upper": np.array([np.nan])}, "lower must be below upper"),
        ({"next_state": lambda x, u: x[0]}, "next_state has shape"),
        ({"continuation": lambda x, u: x}, "continuation has shape"),
        ({"terminal_cost": lambda x, u: ca.sumsqr(u)}, "must not depend on the inputs"),
        ({"decision_guess": np.zeros(1)}, "decision_guess"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(changes, message):
    with pytest.raises(ValueError, match=message):
        integrator(**changes)


@pytest.mark.parametrize("penalty", [0.0, -1.0, np.inf, np.nan])
def test_soft_inequality_needs_a_penalty_that_penalises(penalty):
    with pytest.raises(ValueError, match="penalty of 'speed'"):
        Inequality(ca.SX.sym("h"), penalty, "speed")


def build(orbit, **changes):
    data = {
        "horizon": 10,
        "step": 1.0,
        "state_weight": np.diag([0.008, 0.09, 0.05, 0.04, 0.9]),
        "input_weight": np.eye(3),
        "terminal_weight": 2.0 * np.eye(5),
        "input_lower": -np.ones(3),
        "input_upper": np.ones(3),
    }
    return quadratic_problem(error_dynamics("exact", orbit, 1.0), **{**data, **changes})


def test_costs_are_14(orbit):
    problem = build(orbit)
    symbols = [problem.state, problem.inputs, problem.parameter]
    costs = ca.Function("costs", symbols, [problem.stage_cost, problem.terminal_cost])
    x, u = np.array([1.0, 2.0, 3.0, 4.0, 5.0]), np.array([0.1, 0.2, 0.3])
    stage, terminal = (float(value) for value in costs(x, u, problem.parameter_values))
    assert stage == pytest.approx(np.sum([0.008, 0.36, 0.45, 0.64, 22.5]) + 0.14)
    assert terminal == pytest.approx(2.0 * 55.0)


def test_terminal_set_is_16e(orbit):
    problem = build(orbit, terminal_set=TerminalSet(7.0))
    (constraint,) = problem.terminal_inequalities
    value = ca.Function("excess", [problem.state, problem.parameter], [constraint.expression])
    assert constraint.penalty is None
    assert float(value([1.0, 0.0, 0.0, 0.0, 0.0], problem.parameter_values)) == pytest.approx(
        2.0 - 7.0
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"state_weight": np.eye(4)}, "state_weight has shape"),
        ({"input_weight": -np.eye(3)}, "input_weight has eigenvalue -1"),
        ({"terminal_weight": np.full((5, 5), np.nan)}, "terminal_weight must be finite"),
        ({"input_weight": np.triu(np.ones((3, 3)))}, "symmetric"),
    ],
)
def test_bad_weights_are_named(orbit, changes, message):
    with pytest.raises(ValueError, match=message):
        build(orbit, **changes)


@pytest.mark.parametrize("level", [0.0, -1.0, np.nan, np.inf])
def test_empty_terminal_set_is_refused(level):
    with pytest.raises(ValueError, match="terminal level"):
        TerminalSet(level)
