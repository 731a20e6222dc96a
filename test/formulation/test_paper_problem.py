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

from uav_tracking_mpc.formulation.paper_problem import problem_of, stability_problem
from uav_tracking_mpc.mpc.stage_code import stage_module
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.terminal import ingredients as terminal


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
