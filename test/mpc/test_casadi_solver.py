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

"""IPOPT on the nonlinear program, and the plans from which it begins."""

from __future__ import annotations

from threading import Thread

import casadi as ca
import numpy as np
import pytest
from scipy.optimize import minimize
from solver_problems import PAPER_START, integrator, paper, paper_solver

from uav_tracking_mpc.dynamics.relative import tracking_error
from uav_tracking_mpc.formulation.paper_formulation import problem_of
from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver, NonlinearProgram, plan_guesses
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.problem import Inequality
from uav_tracking_mpc.mpc.solver import Guess, Solution, Status
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.symbolic.functions import LOCK

PROBLEM = paper_solver().problem
STATE = np.full(PROBLEM.nx, 0.5)


def rolled(inputs, decision):
    return np.vstack([STATE, np.tile(inputs.sum(axis=1), (PROBLEM.nx, 1)).T])


def last():
    plan = Solution.without_plan(PROBLEM, Status.FAILED, "", 0.0)
    stages = np.arange(PROBLEM.horizon, dtype=float)[:, np.newaxis]
    return plan._replace(inputs=stages * np.ones(PROBLEM.nu))


def test_a_warm_start_moves_the_last_plan_on_and_begins_at_the_state():
    (guess,) = plan_guesses(PROBLEM, STATE, last(), PROBLEM.step, None, rolled)
    np.testing.assert_array_equal(guess.states[0], STATE)
    np.testing.assert_allclose(guess.inputs[:3, 0], [1.0, 2.0, 3.0])
    assert guess.inputs[-1, 0] == PROBLEM.horizon - 1


def test_a_cold_start_takes_the_plan_of_the_caller_or_two_of_its_own():
    told = Guess(np.full((PROBLEM.horizon, PROBLEM.nu), 0.1), np.zeros(PROBLEM.na))
    (guess,) = plan_guesses(PROBLEM, STATE, last(), None, lambda: told, rolled)
    np.testing.assert_array_equal(guess.inputs, told.inputs)
    np.testing.assert_array_equal(guess.states, rolled(told.inputs, told.decision))
    for make in (None, lambda: None):
        goal, still = plan_guesses(PROBLEM, STATE, None, PROBLEM.step, make, rolled)
        np.testing.assert_array_equal(goal.states[1:], 0.0)
        np.testing.assert_array_equal(still.states, np.tile(STATE, (PROBLEM.horizon + 1, 1)))
        np.testing.assert_array_equal(goal.states[0], STATE)


def test_a_plan_survives_packing_and_rolling_out():
    problem = paper()
    program, plan = NonlinearProgram(problem), NewtonSolver(problem).solve(PAPER_START)
    p = np.tile(problem.usual_parameter, (problem.horizon + 1, 1))
    states = program.rollout(plan.states[0], plan.inputs, p, plan.decision)
    np.testing.assert_allclose(states, plan.states, rtol=1e-9, atol=1e-9)
    unpacked = program.unpack(program.pack(plan.states, plan.inputs, plan.decision))
    for found, packed in zip(unpacked, (plan.states, plan.inputs, plan.decision), strict=True):
        np.testing.assert_array_equal(found, packed)


def test_where_the_model_has_no_value_the_guess_stands_still():
    problem = paper()
    inputs = np.full((problem.horizon, problem.nu), np.nan)
    p = np.tile(problem.usual_parameter, (problem.horizon + 1, 1))
    states = NonlinearProgram(problem).rollout(PAPER_START, inputs, p, np.zeros(0))
    np.testing.assert_array_equal(states, np.tile(PAPER_START, (problem.horizon + 1, 1)))


PAPER = TrackingParameters()


@pytest.mark.parametrize(
    ("model", "cost", "first"),
    [("exact", 642.740, (0.6754, 0.7854, 1.0)), ("paper", 722.430, (0.6793, 0.5487, 1.0))],
)
def test_paper_start_costs_what_was_verified(model, cost, first, paper_start):
    """V_N(x_o) and the first input of Section 6, verified independently."""
    parameters = TrackingParameters(model=model)
    solver = CasadiSolver(problem_of(parameters))
    solution = solver.solve(tracking_error(paper_start, parameters.orbit))
    assert solution.converged
    assert solution.cost == pytest.approx(cost, abs=6e-4)
    np.testing.assert_allclose(solution.inputs[0] + parameters.steady_inputs, first, atol=6e-5)


def test_optimum_agrees_with_scipy():
    """A small problem, condensed and handed to an independent optimiser."""
    problem = integrator(horizon=8)
    start = np.array([1.0, 0.3])

    def cost(inputs):
        x, total = start, 0.0
        for u in inputs:
            total += x @ x + u * u
            x = np.array([x[0] + 0.1 * x[1], x[1] + 0.1 * u])
        return total + x @ x

    oracle = minimize(cost, np.zeros(8), bounds=[(-1.0, 1.0)] * 8, tol=1e-14)
    solution = CasadiSolver(problem).solve(start)
    assert solution.cost == pytest.approx(oracle.fun, rel=1e-7)
    np.testing.assert_allclose(solution.inputs.ravel(), oracle.x, atol=1e-4)


def test_hard_terminal_set_is_infeasible_from_the_paper_start_with_ten_steps(paper_start):
    """(16e) cannot be met from x_o with N = 10; with N = 20 it can."""
    short = TrackingParameters(terminal_constraint="hard")
    solution = CasadiSolver(problem_of(short)).solve(tracking_error(paper_start, short.orbit))
    assert solution.status is Status.INFEASIBLE
    assert "infeasible" in solution.message
    assert solution.violation > 1.0
    long = TrackingParameters(terminal_constraint="hard", horizon=20)
    problem = problem_of(long)
    solution = CasadiSolver(problem).solve(tracking_error(paper_start, long.orbit))
    (terminal,) = problem.terminal_inequalities
    excess = ca.Function("excess", [problem.state, problem.parameter], [terminal.expression])
    assert solution.converged
    assert float(excess(solution.states[-1], problem.parameter_values)) <= 1e-5


def test_soft_terminal_set_is_exact_where_it_can_be_met(paper_start):
    """Above the multiplier an L1 penalty gives the hard problem's solution."""
    solutions = [
        CasadiSolver(
            problem_of(TrackingParameters(terminal_constraint=kind, horizon=12, model="exact"))
        ).solve(np.array([20.0, 0.3, -5.0, 0.0, 0.5]))
        for kind in ("hard", "soft")
    ]
    assert all(solution.converged for solution in solutions)
    np.testing.assert_allclose(solutions[0].inputs, solutions[1].inputs, atol=1e-4)


def test_another_budget_waits_until_nobody_else_builds_expressions():
    solver = CasadiSolver(integrator(horizon=2))
    before = solver._cold
    with LOCK:
        change = Thread(target=setattr, args=(solver, "time_limit", 0.5))
        change.start()
        change.join(0.2)
        assert solver._cold is before
    change.join()
    assert solver._cold is not before


def test_where_the_callers_guess_fails_it_starts_at_rest():
    problem, start = integrator(horizon=8), np.array([1.0, 0.3])
    guess = Guess(np.full((8, 1), np.nan), np.zeros(0))
    solution = CasadiSolver(problem).solve(start, guess=lambda: guess)
    assert solution.converged
    assert solution.cost == pytest.approx(CasadiSolver(problem).solve(start).cost)


def test_iteration_limit_is_said(paper_start):
    solver = CasadiSolver(problem_of(PAPER), iteration_limit=2)
    solution = solver.solve(tracking_error(paper_start, PAPER.orbit))
    assert solution.status in (Status.ITERATION_LIMIT, Status.INFEASIBLE)
    assert not solution.converged


def test_after_a_failure_the_next_solve_starts_cold(paper_start):
    solver = CasadiSolver(problem_of(TrackingParameters(terminal_constraint="hard")))
    failed = solver.solve(tracking_error(paper_start, PAPER.orbit))
    near = np.array([1.0, 0.01, 0.5, 0.0, 0.0])
    after, fresh = solver.solve(near, elapsed=1.0), None
    solver.reset()
    fresh = solver.solve(near)
    assert not failed.converged
    assert after.converged
    assert after.cost == pytest.approx(fresh.cost, rel=1e-9)


def test_a_warm_solve_that_fails_is_followed_by_a_cold_one(paper_start):
    solver = CasadiSolver(problem_of(PAPER), iteration_limit=8)
    assert solver.solve(np.array([0.1, 0.0, 0.1, 0.0, 0.0])).converged
    asked = []
    solver.solve(
        tracking_error(paper_start, PAPER.orbit), elapsed=1.0, guess=lambda: asked.append(1)
    )
    assert asked == [1]


@pytest.mark.parametrize(
    ("penalty", "start", "slowest"),
    [(None, [3.0, 0.0], -0.2), (1e3, [3.0, 0.0], -0.2), (1e3, [0.0, -1.0], -1.0)],
)
def test_stage_inequality_hard_and_soft(penalty, start, slowest):
    """Velocity of a double integrator kept above -0.2; a soft one where it can be."""
    problem = integrator(
        stage_inequalities=lambda x, u: (Inequality(-x[1] - 0.2, penalty, "velocity"),)
    )
    solution = CasadiSolver(problem).solve(start)
    assert solution.converged
    assert np.min(solution.states[:-1, 1]) == pytest.approx(slowest, abs=1e-5)


def test_constant_decision_and_terminal_equality():
    """The optimiser chooses where to rest; resting is enforced at the end."""
    a = ca.SX.sym("a", 1)
    problem = integrator(
        horizon=20,
        stage_cost=lambda x, u: ca.sumsqr(x - ca.vertcat(a, 0)) + ca.sumsqr(u) + (a - 5.0) ** 2,
        terminal_cost=ca.SX(0),
        terminal_equality=lambda x, u: x - ca.vertcat(a, 0),
        decision=a,
        decision_lower=np.array([-10.0]),
        decision_upper=np.array([10.0]),
        decision_guess=np.array([0.0]),
    )
    solution = CasadiSolver(problem).solve([0.0, 0.0])
    assert solution.converged
    np.testing.assert_allclose(solution.states[-1], [solution.decision[0], 0.0], atol=1e-6)
    assert 0.1 < solution.decision[0] < 5.0


def test_parameters_may_differ_from_stage_to_stage():
    p = ca.SX.sym("p", 1)
    problem = integrator(
        parameter=p, stage_cost=lambda x, u: ca.sumsqr(u - p), terminal_cost=ca.SX(0)
    )
    values = np.linspace(-0.5, 0.5, problem.horizon + 1).reshape(-1, 1)
    solution = CasadiSolver(problem).solve([0.0, 0.0], values)
    np.testing.assert_allclose(solution.inputs, values[:-1], atol=1e-6)
