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


from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.dynamics.relative import tracking_error, vehicle_state
from uav_tracking_mpc.estimation.situation import steady_forecast
from uav_tracking_mpc.formulation.paper_formulation import (
    PaperFormulation,
    problem_of,
    stability_problem,
)
from uav_tracking_mpc.mpc.stage_code import stage_module
from uav_tracking_mpc.parameters.specification import ParameterError, taken
from uav_tracking_mpc.settings.tracking import PaperParameters, TrackingParameters
from uav_tracking_mpc.terminal import ingredients as terminal

PARAMETERS = TrackingParameters(solve_time_max=5.0)  # the load of the machine is not tested


@pytest.fixture(scope="module")
def shared():
    return PaperFormulation(PARAMETERS)


@pytest.fixture
def formulation(shared):
    shared.reset()
    shared.change(PARAMETERS)
    return shared


def situation_of(relative, azimuth=0.4, target=(0.0, 0.0, 0.0)):
    vehicle = vehicle_state(relative, azimuth, np.zeros(3))
    return small_uav.situation(*vehicle, target=target)


def plan_of(formulation, now, elapsed=None):
    forecast = steady_forecast(now, PARAMETERS.horizon)
    return formulation.solve(now, forecast, PARAMETERS.orbit, elapsed)


def test_the_plan_is_the_solution_about_the_steady_turn(formulation, paper_start):
    plan = plan_of(formulation, situation_of(paper_start))
    np.testing.assert_allclose(plan.error, tracking_error(paper_start, PARAMETERS.orbit), atol=1e-9)
    expected = plan.solution.inputs + PARAMETERS.steady_inputs
    np.testing.assert_array_equal(plan.inputs, expected)
    np.testing.assert_allclose(plan.inputs[0], [0.6754, 0.7854, 1.0], atol=6e-5)
    assert plan.step == 1.0


def test_the_papers_parameters_alone_pose_its_problem(formulation, paper_start):
    own, now = PaperFormulation(taken(PaperParameters, PARAMETERS)), situation_of(paper_start)
    np.testing.assert_array_equal(plan_of(own, now).inputs, plan_of(formulation, now).inputs)


def test_only_the_relative_motion_matters(formulation, paper_start):
    plans = []
    for azimuth, target in ((0.4, (0.0, 0.0, 0.0)), (-2.9, (1e3, -2e3, 70.0))):
        formulation.reset()
        plans.append(plan_of(formulation, situation_of(paper_start, azimuth, target)).inputs)
    np.testing.assert_allclose(plans[0], plans[1], atol=1e-6)


def test_along_its_own_plan_the_cost_falls_as_54_says(formulation, paper_start):
    first = plan_of(formulation, situation_of(paper_start))
    assert first.decrease is None
    following = first.solution.states[1] + PARAMETERS.orbit.steady_state
    second = plan_of(formulation, situation_of(following), elapsed=1.0)
    assert second.decrease.held
    assert second.solution.cost == second.decrease.cost < second.decrease.bound
    assert second.decrease.bound < first.solution.cost


def test_a_cost_that_rises_is_said_to_be_the_targets_doing(formulation, paper_start):
    plan_of(formulation, situation_of(PARAMETERS.orbit.steady_state))
    moved = situation_of(paper_start, target=(30.0, 0.0, 0.0))
    check = plan_of(formulation, moved, elapsed=1.0).decrease
    assert not check.held
    assert "target or wind moved" in check.reason


def test_the_time_budget_changes_in_flight(formulation):
    formulation.change(replace(PARAMETERS, solve_time_max=1.5))
    assert formulation.solver.time_limit == 1.5


@pytest.mark.parametrize("solver", ["newton", "ipopt"])
@pytest.mark.parametrize("constraint", ["none", "hard"])
def test_a_new_orbit_is_flown_as_if_from_the_start(solver, constraint):
    kind = {"solver": solver, "terminal_constraint": constraint, "solve_time_max": 5.0}
    first = replace(PARAMETERS, **kind)
    second = replace(first, range=170.0, altitude=40.0, airspeed=5.0, direction="counter_clockwise")
    changed, fresh = PaperFormulation(first), PaperFormulation(second)
    now = situation_of(second.orbit.steady_state + np.array([10.0, 0.3, -4.0, 0.05, 0.4]))
    forecast = steady_forecast(now, PARAMETERS.horizon)
    changed.solve(now, forecast, first.orbit, None)
    changed.decrease.failed = 3
    changed.change(second)
    plan, wanted = (each.solve(now, forecast, second.orbit, None) for each in (changed, fresh))
    np.testing.assert_allclose(plan.inputs, wanted.inputs, atol=1e-7)
    assert plan.solution.converged
    assert plan.decrease is None  # of another orbit the step before says nothing
    np.testing.assert_array_equal(changed.decrease.weight, fresh.decrease.weight)
    assert changed.decrease.level == fresh.decrease.level
    assert changed.decrease.failed == 3


def test_ipopt_is_made_when_asked_for():
    assert PaperFormulation(replace(PARAMETERS, solver="ipopt")).solver.name == "ipopt"


def test_box_is_taken_about_the_steady_inputs():
    parameters = TrackingParameters()
    problem = problem_of(parameters)
    np.testing.assert_allclose(
        problem.input_upper + parameters.steady_inputs, parameters.input_upper
    )
    assert problem.input_upper[0] > -problem.input_lower[0]


@pytest.mark.parametrize(("kind", "penalty"), [("soft", 100.0), ("hard", None)])
def test_terminal_set_is_as_large_as_the_inputs_allow(kind, penalty):
    problem = problem_of(TrackingParameters(terminal_constraint=kind))
    (terminal,) = problem.terminal_inequalities
    excess = ca.Function("h", [problem.state, problem.parameter], [terminal.expression])
    level = -float(excess(0, problem.parameter_values))
    assert terminal.penalty == penalty
    assert level == pytest.approx(2.878, abs=5e-4)


def test_no_terminal_set_by_default():
    assert problem_of(TrackingParameters()).terminal_inequalities == ()


def test_weights_that_give_no_terminal_controller_are_named(monkeypatch):
    """Where the Riccati equation cannot be solved (weights fifteen decades apart, for one)."""

    def unsolvable(*_):
        raise np.linalg.LinAlgError("the pencil has eigenvalues on the unit circle")

    monkeypatch.setattr(terminal, "solve_discrete_are", unsolvable)
    with pytest.raises(ParameterError, match="'input_weights'.* unit circle"):
        problem_of(TrackingParameters())


def test_every_orbit_has_the_same_expressions():
    """So that a solver is compiled once; the expressions agree with those of each orbit alone."""
    paper = problem_of(TrackingParameters())
    for values in ({"range": 160.0}, {"direction": "counter_clockwise", "airspeed": 5.0}):
        parameters = TrackingParameters(**values)
        other = problem_of(parameters)
        assert stage_module(other) == stage_module(paper)
        step = ca.Function("f", [paper.state, paper.inputs, paper.parameter], [paper.next_state])
        x, u = [3.0, -0.4, 2.0, 0.1, -0.5], [0.02, -0.03, 0.1]
        alone = stability_problem(parameters).dynamics()(x, u)
        np.testing.assert_allclose(step(x, u, other.parameter_values), alone, rtol=0, atol=1e-12)
