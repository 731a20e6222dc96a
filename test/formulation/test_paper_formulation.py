from dataclasses import replace

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.dynamics.relative import tracking_error, vehicle_state
from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.formulation.paper_formulation import PaperFormulation
from uav_tracking_mpc.settings.tracking import TrackingParameters

PARAMETERS = TrackingParameters()


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


def test_ipopt_is_made_when_asked_for():
    assert PaperFormulation(replace(PARAMETERS, solver="ipopt")).solver.name == "ipopt"
