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

"""What every solver owes, and the shift of a warm start."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solver_problems import PAPER_START, paper, paper_solver, pendulum

from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solver import Status, shift

SAMPLES = np.column_stack([np.arange(6.0), np.arange(6.0) ** 2])
IPOPT = CasadiSolver(paper())
BY_EACH = pytest.mark.parametrize("solver", [paper_solver(), IPOPT], ids=lambda each: each.name)


@given(st.floats(0.0, 20.0))
def test_a_straight_line_stays_one_and_its_last_sample_is_held(stages):
    np.testing.assert_array_equal(shift(SAMPLES, 0.0), SAMPLES)
    np.testing.assert_array_equal(shift(SAMPLES, 2.0), SAMPLES[[2, 3, 4, 5, 5, 5]])
    np.testing.assert_allclose(
        shift(SAMPLES, stages)[:, 0], np.minimum(np.arange(6) + stages, 5.0), atol=1e-12
    )


@BY_EACH
def test_a_plan_obeys_the_model(solver):
    """(16b): the states are those that the inputs make."""
    solver.reset()
    problem, plan = solver.problem, solver.solve(PAPER_START)
    symbols = [problem.state, problem.inputs, problem.parameter]
    model = ca.Function("f", symbols, [problem.next_state]).map(problem.horizon)
    following = model(plan.states[:-1].T, plan.inputs.T, problem.parameter_values).full().T
    np.testing.assert_allclose(plan.states[1:], following, atol=1e-6)


@BY_EACH
def test_a_warm_start_takes_fewer_iterations_to_the_same_optimum(solver):
    solver.reset()
    state = solver.solve(PAPER_START).states[1]
    warm = solver.solve(state, elapsed=1.0)
    solver.reset()
    cold = solver.solve(state)
    assert warm.iterations <= min(cold.iterations, 15)
    assert warm.cost == pytest.approx(cold.cost, rel=1e-6)


@BY_EACH
@pytest.mark.parametrize(
    "bad", [np.full(5, np.nan), [0, np.inf, 0, 0, 0], np.zeros(4), ["a"] * 5, "no state", None]
)
def test_bad_data_are_refused_and_leave_the_warm_start_as_it_was(solver, bad):
    plans = []
    for disturbed in (False, True):
        solver.reset()
        first = solver.solve(PAPER_START)
        if disturbed:
            refused = solver.solve(bad, elapsed=1.0)
            assert refused.status is Status.REFUSED and "refused" in refused.message
            assert np.all(np.isfinite(refused.inputs))
        plans.append(solver.solve(first.states[1], elapsed=1.0))
    assert plans[0].iterations == plans[1].iterations
    np.testing.assert_array_equal(plans[0].inputs, plans[1].inputs)


@pytest.mark.parametrize("make", [NewtonSolver, CasadiSolver])
def test_bad_parameters_are_refused(make):
    problem = pendulum(speed_penalty=50.0)
    p = np.zeros((problem.horizon + 1, 1))
    p[3] = np.nan
    assert make(problem).solve(np.zeros(2), p).status is Status.REFUSED


@pytest.mark.parametrize(
    "solver",
    [paper_solver(), CasadiSolver(paper(), iteration_limit=30)],
    ids=lambda each: each.name,
)
@given(st.tuples(*[st.floats(-1e3, 1e3)] * 5))
def test_inputs_are_finite_and_in_the_box_from_anywhere(solver, state):
    solver.reset()
    plan = solver.solve(np.array(state))
    assert plan.inputs.shape == (solver.problem.horizon, 3)
    assert np.all(plan.inputs >= solver.problem.input_lower)
    assert np.all(plan.inputs <= solver.problem.input_upper)
