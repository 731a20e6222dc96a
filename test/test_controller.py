from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from uav_tracking_mpc.guidance.controller import Source, TrackingController
from uav_tracking_mpc.guidance.tracking_parameters import TrackingParameters
from uav_tracking_mpc.mpc.solution import Status

PARAMETERS = TrackingParameters()


class FailingSolver:
    """Passes solves on until it is told to fail."""

    def __init__(self, solver):
        self.solver, self.failing = solver, False
        self.name, self.problem = solver.name, solver.problem
        self.reset = solver.reset

    def solve(self, initial_state, parameters=None, elapsed=None):
        solution = self.solver.solve(initial_state, parameters, elapsed)
        if self.failing:
            return replace(solution, status=Status.FAILED, message="failed: told to")
        return solution


@pytest.fixture
def controller():
    inner = TrackingController(PARAMETERS)
    return TrackingController(PARAMETERS, FailingSolver(inner.solver))


def test_on_the_orbit_the_steady_turn_is_commanded(controller):
    command = controller.step(PARAMETERS.orbit.steady_state)
    assert command.source is Source.OPTIMAL
    assert command.reason == ""
    np.testing.assert_allclose(command.inputs[0], PARAMETERS.steady_inputs, atol=1e-6)


def test_command_is_the_first_of_the_plan(controller, paper_start):
    command = controller.step(paper_start)
    np.testing.assert_allclose(command.inputs[0], [0.6754, 0.7854, 1.0], atol=6e-5)
    assert command.inputs.shape == (PARAMETERS.horizon, 3)


def test_a_failed_solve_is_bridged_by_the_earlier_plan(controller, paper_start):
    plan = controller.step(paper_start).inputs
    controller.solver.failing = True
    bridged = controller.step(paper_start, elapsed=1.5)
    assert bridged.source is Source.EARLIER_PLAN
    assert bridged.reason == "failed: told to"
    np.testing.assert_array_equal(bridged.inputs, plan[1:])  # 1.5 s later the second stage runs


def test_an_earlier_plan_is_not_flown_for_ever(controller, paper_start):
    controller.step(paper_start)
    controller.solver.failing = True
    controller.step(paper_start, elapsed=1.0)
    late = controller.step(np.array([200.0, 0.0, 20.0, 0.1, 4.0]), elapsed=1.5)
    assert late.source is Source.WINGS_LEVEL
    np.testing.assert_allclose(late.inputs, [[0.0, -0.1, 0.0]])  # no turn, path angle taken out


def test_after_a_failure_it_returns_to_optimal_plans(controller, paper_start):
    controller.step(paper_start)
    controller.solver.failing = True
    controller.step(paper_start, elapsed=5.0)
    controller.solver.failing = False
    assert controller.step(paper_start, elapsed=0.1).source is Source.OPTIMAL


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(), min_size=5, max_size=5), st.sampled_from([None, 0.1, -1.0, 1e9]))
def test_whatever_comes_in_the_command_is_finite_and_inside_the_limits(relative, elapsed):
    controller = test_whatever_comes_in_the_command_is_finite_and_inside_the_limits.controller
    command = controller.step(relative, elapsed)
    assert np.all(np.isfinite(command.inputs))
    assert np.all(command.inputs >= PARAMETERS.input_lower)
    assert np.all(command.inputs <= PARAMETERS.input_upper)


test_whatever_comes_in_the_command_is_finite_and_inside_the_limits.controller = TrackingController(
    PARAMETERS
)


def test_reset_forgets_the_plan(controller, paper_start):
    controller.step(paper_start)
    controller.reset()
    controller.solver.failing = True
    assert controller.step(paper_start, elapsed=0.1).source is Source.WINGS_LEVEL
