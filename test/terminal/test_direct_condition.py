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

"""The proof: true at the levels asked for, never true for a seeded fault."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("flint")

from uav_tracking_mpc.dynamics.relative_models.exact import Exact
from uav_tracking_mpc.terminal.direct_condition import decrease, prove_direct_condition
from uav_tracking_mpc.terminal.quadratic_bound import is_violated
from uav_tracking_mpc.terminal.stability_problem import paper_problem
from uav_tracking_mpc.terminal.theorems import q_star
from uav_tracking_mpc.terminal.violation import Excess, directions, lowest_violation


def attempt(problem, ingredients, level, box_limit=2000):
    return prove_direct_condition(problem, ingredients, level, box_limit)


def test_exact_model_with_the_papers_inputs():
    problem = paper_problem()
    answer = attempt(problem, problem.ingredients(), 2.87)
    assert answer.holds
    assert answer.inputs.level == pytest.approx(2.878, abs=1e-3)
    assert "u_chi" in answer.inputs.name


def test_paper_model_has_no_decrease_at_level_5():
    """A state of the ellipsoid of level 5 where V_f does not fall enough, confirmed with balls."""
    problem = paper_problem("paper")
    parts = problem.ingredients()
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    excess = Excess(problem.dynamics(), parts.gain, parts.weight, parts.weight - star)
    found = lowest_violation(excess, 15.0)
    assert found is not None
    assert found.level == pytest.approx(4.887, abs=1e-3)
    assert is_violated(decrease(problem, parts, 5.0), found.state)


def test_level_beyond_the_inputs_is_rejected():
    problem = paper_problem()
    parts = problem.ingredients()
    answer = attempt(problem, parts, 1.01 * 2.8783)
    assert not answer.holds
    assert "u_chi" in answer.reason


def test_level_one_percent_beyond_the_true_limit_is_rejected():
    base = paper_problem("paper")
    problem = replace(base, input_lower=9 * base.input_lower, input_upper=9 * base.input_upper)
    answer = attempt(problem, problem.ingredients(), 1.01 * 4.88698)
    assert not answer.holds
    assert answer.decrease.stuck is not None
    assert answer.decrease.tree == ""


@pytest.mark.parametrize("fault", ["sign of a column", "twice too large", "rows exchanged"])
def test_wrong_gain_is_rejected(fault):
    problem = paper_problem()
    parts = problem.ingredients()
    gain = parts.gain.copy()
    if fault == "sign of a column":
        gain[:, 1] *= -1.0
    elif fault == "twice too large":
        gain *= 2.0
    else:
        gain = gain[[1, 0, 2]]
    assert not attempt(problem, replace(parts, gain=gain), 0.5).holds


@pytest.mark.parametrize("fault", ["range rate", "climb rate", "turn-rate input"])
def test_sign_error_in_the_model_is_rejected(fault, monkeypatch):
    problem = paper_problem()
    parts = problem.ingredients()
    right = Exact.rates

    def wrong(self, state, inputs):
        rates = right(self, state, inputs)
        if fault == "range rate":
            rates[0] = -rates[0]
        elif fault == "climb rate":
            rates[2] = -rates[2]
        else:
            rates[1] -= 2.0 * inputs[0]
        return rates

    monkeypatch.setattr(Exact, "rates", wrong)
    try:
        answer = attempt(problem, parts, 0.5)
    except ArithmeticError:  # the wrong model has no such steady state: rejected as well
        return
    assert not answer.holds


def test_proved_decrease_agrees_with_samples():
    problem = paper_problem()
    parts = problem.ingredients()
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    excess = Excess(problem.dynamics(), parts.gain, parts.weight, parts.weight - star)
    generator = np.random.default_rng(1)
    states = directions(parts.weight, 5000, generator) * np.sqrt(
        2.87 * generator.uniform(0.0, 1.0, (5000, 1))
    )
    assert np.all(excess(states) <= 0.0)


def test_counter_clockwise_orbit_is_proved_too():
    base = paper_problem()
    problem = replace(base, orbit=replace(base.orbit, direction="counter_clockwise"))
    assert attempt(problem, problem.ingredients(), 2.87).holds


def test_no_room_in_the_linear_part_at_rho_one():
    problem = paper_problem(scaling=1.0)
    answer = attempt(problem, problem.ingredients(), 0.01)
    assert not answer.holds
    assert answer.decrease.stuck is not None
