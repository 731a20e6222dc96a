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

import contextlib
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
from uav_tracking_mpc.studies.stability.stability_campaign import random_states
from uav_tracking_mpc.terminal.ingredients import decrease_excess, paper_problem

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
    leaves = proof.statistics["leaves"]
    assert leaves == proof.tree.count(".") == len(proof.multipliers)
    assert proof.statistics["boxes"] == len(proof.tree) == 2 * leaves - 1
    assert proof == prove(decrease(PROBLEM, PARTS, 2.8))  # at any load of the machine


def test_a_spent_budget_ends_a_proof_with_why_it_stopped_and_what_to_do():
    proof = prove(decrease(PROBLEM, PARTS, 11.0), box_limit=5)
    assert not proof.proved
    assert proof.statistics["boxes"] == 5
    assert proof.tree == ""
    assert "budget of 5 boxes is spent" in proof.stuck
    assert "--boxes" in proof.stuck


def test_asymmetric_weight_is_refused():
    crooked = PARTS.weight.copy()
    crooked[0, 1] = np.nextafter(crooked[0, 1], 1.0)
    with pytest.raises(ValueError, match="symmetric"):
        lipschitz_bound(PROBLEM, replace(PARTS, weight=crooked), 0.1, 1.0)


def attempt(problem, level, parts=None):
    return prove_direct_condition(problem, parts or problem.ingredients(), level, 2000)


@pytest.mark.parametrize("direction", ["clockwise", "counter_clockwise"])
def test_exact_model_with_the_papers_inputs(direction):
    answer = attempt(replace(PROBLEM, orbit=replace(PROBLEM.orbit, direction=direction)), 2.87)
    assert answer.holds
    assert answer.inputs.level == pytest.approx(2.878, abs=1e-3)
    assert "u_chi" in answer.inputs.name


def test_paper_model_has_no_decrease_at_level_5():
    """A state of the ellipsoid of level 5 where V_f does not fall enough, in intervals."""
    problem = paper_problem("paper")
    parts = problem.ingredients()
    found = lowest_violation(decrease_excess(problem, parts), 15.0)
    assert found.level == pytest.approx(4.887, abs=1e-3)
    assert decrease(problem, parts, 5.0).violated_at(found.state)


PAPER = paper_problem("paper")


@pytest.mark.parametrize(
    ("problem", "parts", "level", "reason"),
    [
        (PROBLEM, PARTS, 1.01 * 2.8783, "u_chi"),  # beyond the inputs
        # one percent beyond the true limit, where the inputs would allow more
        (
            replace(PAPER, input_lower=9 * PAPER.input_lower, input_upper=9 * PAPER.input_upper),
            PAPER.ingredients(),
            1.01 * 4.88698,
            "decrease",
        ),
        (paper_problem(scaling=1.0), None, 0.01, "decrease"),  # no room in the linear part
        # wrong gains: sign of a column, twice too large, rows exchanged
        (PROBLEM, replace(PARTS, gain=PARTS.gain * [1.0, -1.0, 1.0, 1.0, 1.0]), 0.5, ""),
        (PROBLEM, replace(PARTS, gain=2.0 * PARTS.gain), 0.5, ""),
        (PROBLEM, replace(PARTS, gain=PARTS.gain[[1, 0, 2]]), 0.5, ""),
    ],
)
def test_what_is_no_terminal_set_is_rejected(problem, parts, level, reason):
    answer = attempt(problem, level, parts)
    assert not answer.holds
    assert reason in answer.reason
    assert answer.decrease.proved or answer.decrease.tree == ""


@pytest.mark.parametrize(
    ("index", "wrong_rate"),
    [
        (0, lambda rate, inputs: -rate),  # of the range
        (2, lambda rate, inputs: -rate),  # of the climb
        (1, lambda rate, inputs: rate - 2.0 * inputs[0]),  # by the turn-rate input
    ],
)
def test_sign_error_in_the_model_is_rejected(index, wrong_rate, monkeypatch):
    right = Exact.rates

    def wrong(self, state, inputs):
        rates = right(self, state, inputs)
        rates[index] = wrong_rate(rates[index], inputs)
        return rates

    monkeypatch.setattr(Exact, "rates", wrong)
    # The wrong model may have no such steady state: rejected as well.
    with contextlib.suppress(ArithmeticError):
        assert not attempt(PROBLEM, 0.5, PARTS).holds


def test_proved_decrease_agrees_with_samples():
    excess = decrease_excess(PROBLEM, PARTS)
    assert np.all(excess(random_states(PROBLEM, 2.87, 5000)) <= 0.0)
