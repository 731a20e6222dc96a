import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.formulation.paper_problem import problem_of
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
    level = -float(ca.Function("h", [problem.state], [terminal.expression])(0))
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
