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


from __future__ import annotations

import dataclasses
import tracemalloc
from itertools import islice

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solver_problems import PAPER_START, kkt_residual, paper, paper_solver, pendulum

from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver, openings
from uav_tracking_mpc.mpc.problem import Inequality, OptimalControlProblem, TerminalSet
from uav_tracking_mpc.mpc.solver import Solution, Status, solutions

HARD, SOFT = None, 100.0
JUST_IN_REACH = np.array([20.0, -0.6, -8.0, 0.1, 0.0])


def with_penalty(problem: OptimalControlProblem, penalty: float | None, level: float = 0.0):
    (terminal,) = problem.terminal_inequalities
    terminal = dataclasses.replace(
        terminal, expression=terminal.expression - level, penalty=penalty
    )
    return dataclasses.replace(problem, terminal_inequalities=(terminal,))


def assert_same_plan(ours: Solution, oracle: Solution, slack: float = 0.0) -> None:
    """The same plan and cost.

    IPOPT relaxes every bound by 1e-8, those of its slack variables too, so it reports a cost that
    is too low by 1e-8 times the sum of all penalties: ``slack``.
    """
    assert ours.converged, ours.message
    assert oracle.converged, oracle.message
    assert ours.cost == pytest.approx(oracle.cost + slack, rel=1e-6, abs=0.1 * slack)
    np.testing.assert_allclose(ours.inputs, oracle.inputs, atol=2e-5)
    np.testing.assert_allclose(ours.states, oracle.states, rtol=1e-5, atol=1e-4)
    np.testing.assert_allclose(ours.decision, oracle.decision, atol=1e-5)


@pytest.fixture
def solver() -> NewtonSolver:
    shared = paper_solver()
    shared.reset()
    return shared


def test_papers_problem_agrees_with_ipopt_and_the_published_numbers(solver):
    ours = solver.solve(PAPER_START)
    assert_same_plan(ours, CasadiSolver(paper()).solve(PAPER_START))
    assert ours.cost == pytest.approx(642.740, abs=1e-3)
    assert kkt_residual(paper(), ours, PAPER_START) < 1e-6


@given(
    st.tuples(
        st.floats(-70, 250), st.floats(-4, 3), st.floats(-40, 20), st.floats(-0.4, 0.4),
        st.floats(-3, 4),
    )
)  # fmt: skip
def test_what_converges_is_optimal_from_any_state(state):
    solver = paper_solver()
    solver.reset()
    plan = solver.solve(np.array(state))
    assert not plan.converged or kkt_residual(solver.problem, plan, np.array(state)) < 1e-5


@pytest.mark.parametrize(
    ("penalty", "state"), [(HARD, JUST_IN_REACH), (SOFT, JUST_IN_REACH), (SOFT, PAPER_START)]
)
def test_terminal_ellipsoid_agrees_with_ipopt(penalty, state):
    """Active where it can just be reached; beyond, a soft one pays the exact penalty."""
    problem = with_penalty(paper(ellipsoid=True), penalty)
    ours = NewtonSolver(problem).solve(state)
    assert_same_plan(ours, CasadiSolver(problem).solve(state))
    assert ours.violation < 1e-6
    assert kkt_residual(problem, ours, state) < 1e-6


def test_hard_ellipsoid_out_of_reach_is_infeasible_with_the_violation_named():
    problem = with_penalty(paper(ellipsoid=True), HARD)
    solution = NewtonSolver(problem).solve(PAPER_START)
    assert solution.status is Status.INFEASIBLE
    assert "violated" in solution.message
    assert solution.violation > 1.0
    assert np.all(np.isfinite(solution.inputs))


@pytest.mark.parametrize("speed_penalty", [HARD, 0.3, 50.0])
@pytest.mark.parametrize("push", [0.0, 0.3, "changing"])
def test_problem_with_everything_agrees_with_ipopt(speed_penalty, push):
    problem = pendulum(speed_penalty=speed_penalty)
    changing, state = push == "changing", np.array([-0.3, 0.0])
    p = np.full((problem.horizon + 1, 1), 0.3 if changing else push)
    if changing:
        p[:, 0] *= np.sin(np.arange(problem.horizon + 1.0))
    ours = NewtonSolver(problem).solve(state, p)
    slack = 1e-8 * problem.horizon * 2 * (speed_penalty or 0.0)
    assert_same_plan(ours, CasadiSolver(problem).solve(state, p), slack)
    assert ours.violation < 2e-6
    assert changing or kkt_residual(problem, ours, state, p[0]) < 1e-5


def test_closed_loop_flight_is_that_of_ipopt(solver):
    both = solver, CasadiSolver(paper(), tolerance=1e-8)
    flights = [list(islice(solutions(one, PAPER_START), 150)) for one in both]
    assert all(each.converged for flight in flights for each in flight)
    ours, oracle = (np.array([each.states[1] for each in flight]) for flight in flights)
    assert np.abs(ours - oracle).max() < 1e-4  # [m, rad, m/s]
    assert np.all(np.diff([each.cost for each in flights[0]]) <= 1e-9)


@pytest.mark.parametrize("elapsed", [0.0, 0.02, 0.5, 1.0, 3.7, 100.0])
def test_warm_start_converges_for_any_control_period(solver, elapsed):
    first = solver.solve(PAPER_START)
    where = np.array(
        [np.interp(min(elapsed, 10.0), np.arange(11.0), column) for column in first.states.T]
    )
    warm = solver.solve(where, elapsed=elapsed)
    assert warm.converged
    assert kkt_residual(solver.problem, warm, where) < 1e-6


def test_warm_start_follows_a_change_of_the_state_alone():
    solver, begin, moved = NewtonSolver(pendulum()), np.zeros(2), np.array([0.04, 0.02])
    first = solver.solve(begin, [0.1])
    solver.time_limit = 1e-9  # what a warm solve begins with is also what it ends with
    started = solver.solve(moved, [0.1], elapsed=0.0)
    solver.time_limit = np.inf
    optimum = solver.solve(moved, [0.1])
    changed = np.abs(optimum.inputs - first.inputs).max()
    assert np.abs(started.inputs - optimum.inputs).max() < 0.02 * changed


def test_warm_start_ends_with_the_continuation_and_so_stays_feasible():
    problem, pushed = pendulum(), np.array([0.1])
    solver = NewtonSolver(problem)
    first = solver.solve(np.zeros(2), pushed)
    assert first.converged
    solver.time_limit = 1e-9  # what a warm solve begins with is also what it ends with
    moved = solver.solve(first.states[1], pushed, elapsed=problem.step)
    assert moved.status is Status.TIME_LIMIT
    np.testing.assert_array_equal(moved.inputs[:-1], first.inputs[1:])
    assert moved.inputs[-1] == pytest.approx(np.sin(first.decision[0]) - 0.1, abs=1e-5)
    assert moved.violation < 1e-5
    solver.time_limit = np.inf
    assert solver.solve(first.states[1], pushed, elapsed=problem.step).cost <= first.cost


def test_iteration_limit_gives_a_plan_and_a_cold_start_next():
    limited = NewtonSolver(paper(), iteration_limit=2)
    solution = limited.solve(PAPER_START)
    assert solution.status is Status.ITERATION_LIMIT
    assert np.isfinite(solution.cost)
    shared = paper_solver()
    shared.reset()
    limited.iteration_limit = shared.iteration_limit
    after = limited.solve(solution.states[1], elapsed=1.0)
    cold = shared.solve(solution.states[1])
    assert after.iterations == cold.iterations
    np.testing.assert_array_equal(after.inputs, cold.inputs)


def test_time_limit_ends_the_solve_with_the_best_plan_so_far():
    limited = NewtonSolver(paper(), time_limit=1e-6)
    solution = limited.solve(PAPER_START)
    assert solution.iterations < NewtonSolver(paper()).solve(PAPER_START).iterations
    assert solution.status is Status.TIME_LIMIT
    assert "time limit" in solution.message
    assert np.isfinite(solution.cost)
    assert np.all(np.isfinite(solution.inputs))


def test_state_outside_the_models_domain_is_a_failure_that_says_so(solver):
    solution = solver.solve(np.array([-200.0, 0.0, 0.0, 0.0, 0.0]))  # negative range
    assert solution.status in (Status.FAILED, Status.ITERATION_LIMIT)
    assert np.all(np.isfinite(solution.inputs))
    assert solver.solve(PAPER_START, elapsed=1.0).converged


def test_where_no_plan_begins_none_is_returned():
    """The dynamics overflow at once, and 0 is no input of the box."""
    solver = NewtonSolver(dataclasses.replace(pendulum(), input_lower=np.array([1.0])))
    for _ in range(2):
        lost = solver.solve([0.0, 1e308], [-0.9], elapsed=0.2)
        assert lost.status is Status.FAILED
        assert "not finite" in lost.message
        assert np.isnan(lost.cost)
        assert lost.violation == np.inf
        np.testing.assert_array_equal(lost.inputs, 1.0)
        assert solver.solve([0.2, 0.0], [-0.9]).converged  # which the next must not repeat


def test_a_plan_that_meets_its_constraints_is_not_called_infeasible():
    """The penalty weights end at their limit, for the cost grows that steeply past the bound."""
    x, u = ca.SX.sym("x"), ca.SX.sym("u")
    problem = OptimalControlProblem(
        state=x, inputs=u, next_state=x + u, stage_cost=1e10 * (x - 1.0) ** 2 + u**2,
        terminal_cost=x**2, horizon=5, step=1.0,
        input_lower=np.array([-1.0]), input_upper=np.array([1.0]),
        stage_inequalities=(Inequality(x - 0.5),),
    )  # fmt: skip
    plan = NewtonSolver(problem).solve([0.0])
    assert plan.violation < 1e-6
    assert plan.status is not Status.INFEASIBLE, plan.message


@pytest.mark.parametrize("name", ["tolerance", "iteration_limit", "time_limit"])
def test_limits_that_are_not_positive_are_refused(name):
    with pytest.raises(ValueError, match=name):
        NewtonSolver(paper(), **{name: 0.0})


def test_hot_path_keeps_no_memory(solver):
    state = solver.solve(PAPER_START).states[1]
    for _ in range(10):
        solver.solve(state, elapsed=0.0)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for _ in range(1000):
            solver.solve(state, elapsed=0.0)
        after, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert after - before < 2000  # [bytes]
    assert peak - before < 10_000  # one solution at a time


def test_a_terminal_set_is_the_same_code_whatever_its_penalty():
    soft = NewtonSolver(paper(ellipsoid=True))
    hard = NewtonSolver(with_penalty(paper(ellipsoid=True), HARD))
    assert soft._method is hard._method
    assert TerminalSet(1.0).penalty is None


@pytest.mark.filterwarnings("error")
def test_inputs_without_bounds_open_at_rest():
    free = dataclasses.replace(
        pendulum(), input_lower=np.array([-np.inf]), input_upper=np.array([np.inf])
    )
    assert all(np.all(inputs == 0.0) for inputs in openings(free, np.zeros(1)))
    assert NewtonSolver(free).solve(np.array([-0.3, 0.0])).converged


def test_cold_start_does_not_depend_on_what_was_solved_before():
    solver = paper_solver()
    solver.reset()
    first = solver.solve(PAPER_START)
    solver.solve(-0.3 * PAPER_START)
    again = solver.solve(PAPER_START)
    np.testing.assert_array_equal(first.inputs, again.inputs)
    assert first.iterations == again.iterations
