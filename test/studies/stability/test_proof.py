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

"""Proofs: complete trees, true at the levels asked for, never true for a seeded fault."""

from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.relative_models.kinematics import Exact
from uav_tracking_mpc.studies.stability.analysis import (
    largest_lipschitz,
    lowest_violation,
    theorem3,
    theorem_quantities,
)
from uav_tracking_mpc.studies.stability.proof import (
    decrease,
    lipschitz_bound,
    prove,
    prove_direct_condition,
)
from uav_tracking_mpc.terminal.ingredients import decrease_excess, directions, paper_problem

PROBLEM = paper_problem()
PARTS = PROBLEM.ingredients()


def test_theorem3_holds_up_to_level_1_5_on_the_exact_model():
    found = theorem_quantities(PROBLEM, PARTS, 0.0)
    limit = largest_lipschitz(found["contraction"], theorem3(found)["left"])
    assert prove(lipschitz_bound(PROBLEM, PARTS, limit, 1.5)).proved
    beyond = lipschitz_bound(PROBLEM, PARTS, limit, 1.61)
    assert not prove(beyond, box_limit=200).proved


def test_tree_is_complete_and_counts_add_up():
    proof = prove(decrease(PROBLEM, PARTS, 2.8))
    assert proof.proved
    assert proof.leaves == proof.tree.count(".") == len(proof.multipliers)
    assert proof.boxes == len(proof.tree) == 2 * proof.leaves - 1


def test_a_spent_budget_ends_a_proof_with_why_it_stopped_and_what_to_do():
    proof = prove(decrease(PROBLEM, PARTS, 11.0), box_limit=5)
    assert not proof.proved
    assert proof.boxes == 5
    assert proof.tree == ""
    assert "budget of 5 boxes is spent" in proof.stuck
    assert "--boxes" in proof.stuck


def test_a_proof_is_the_same_at_any_load():
    assert prove(decrease(PROBLEM, PARTS, 2.8)) == prove(decrease(PROBLEM, PARTS, 2.8))


def test_asymmetric_weight_is_refused():
    crooked = PARTS.weight.copy()
    crooked[0, 1] = np.nextafter(crooked[0, 1], 1.0)
    with pytest.raises(ValueError, match="symmetric"):
        lipschitz_bound(PROBLEM, replace(PARTS, weight=crooked), 0.1, 1.0)


def attempt(problem, ingredients, level, box_limit=2000):
    return prove_direct_condition(problem, ingredients, level, box_limit)


def test_exact_model_with_the_papers_inputs():
    problem = paper_problem()
    answer = attempt(problem, problem.ingredients(), 2.87)
    assert answer.holds
    assert answer.inputs.level == pytest.approx(2.878, abs=1e-3)
    assert "u_chi" in answer.inputs.name


def test_paper_model_has_no_decrease_at_level_5():
    """A state of the ellipsoid of level 5 where V_f does not fall enough, in intervals."""
    problem = paper_problem("paper")
    parts = problem.ingredients()
    excess = decrease_excess(problem, parts)
    found = lowest_violation(excess, 15.0)
    assert found is not None
    assert found.level == pytest.approx(4.887, abs=1e-3)
    assert decrease(problem, parts, 5.0).violated_at(found.state)


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
    excess = decrease_excess(problem, parts)
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
