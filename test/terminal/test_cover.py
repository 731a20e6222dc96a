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

"""Branch and bound: complete trees, honest failures, the level of Theorem 3."""

import numpy as np
import pytest

pytest.importorskip("flint")

from uav_tracking_mpc.terminal.cover import prove
from uav_tracking_mpc.terminal.direct_condition import decrease
from uav_tracking_mpc.terminal.quadratic_bound import lipschitz_bound
from uav_tracking_mpc.terminal.stability_problem import paper_problem
from uav_tracking_mpc.terminal.terminal_dynamics import ClosedLoopBalls
from uav_tracking_mpc.terminal.theorems import largest_lipschitz, theorem_quantities

PROBLEM = paper_problem()
PARTS = PROBLEM.ingredients()


def test_theorem3_holds_up_to_level_1_5_on_the_exact_model():
    found = theorem_quantities(PARTS, PROBLEM.state_weight, PROBLEM.input_weight, 0.0, 10)
    limit = largest_lipschitz(found.contraction, found.theorem3.left)
    loop = ClosedLoopBalls("exact", "euler", PROBLEM.orbit, PROBLEM.step, PARTS.gain)
    bound = lipschitz_bound(loop, PARTS.weight, PARTS.closed_loop, limit, 1.5)
    assert prove(bound).proved
    beyond = lipschitz_bound(loop, PARTS.weight, PARTS.closed_loop, limit, 1.61)
    assert not prove(beyond, box_limit=200).proved


def test_tree_is_complete_and_counts_add_up():
    proof = prove(decrease(PROBLEM, PARTS, 2.8))
    assert proof.proved
    assert proof.leaves == proof.tree.count(".") == len(proof.multipliers)
    assert proof.boxes == len(proof.tree) == 2 * proof.leaves - 1


def test_a_spent_budget_ends_a_proof_with_where_it_stopped_and_what_to_do():
    proof = prove(decrease(PROBLEM, PARTS, 11.0), box_limit=5)
    assert not proof.proved
    assert proof.boxes == 5
    assert proof.tree == ""
    assert "budget of 5 boxes is spent" in proof.stuck.reason
    assert "--boxes" in proof.stuck.reason
    assert len(proof.stuck.center) == 5


def test_a_proof_is_the_same_at_any_load():
    assert prove(decrease(PROBLEM, PARTS, 2.8)) == prove(decrease(PROBLEM, PARTS, 2.8))


def test_asymmetric_weight_is_refused():
    crooked = PARTS.weight.copy()
    crooked[0, 1] = np.nextafter(crooked[0, 1], 1.0)
    loop = ClosedLoopBalls("exact", "euler", PROBLEM.orbit, PROBLEM.step, PARTS.gain)
    with pytest.raises(ValueError, match="symmetric"):
        lipschitz_bound(loop, crooked, PARTS.closed_loop, 0.1, 1.0)
