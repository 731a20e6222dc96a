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

"""Theorem quantities against independently computed values and identities."""

import numpy as np
import pytest

from uav_tracking_mpc.terminal.ingredients import terminal_ingredients
from uav_tracking_mpc.terminal.stability_problem import paper_problem
from uav_tracking_mpc.terminal.theorems import c_2, largest_lipschitz, q_star, theorem_quantities


def quantities(model: str, lipschitz: float = 0.5265, scaling: float = 2.5):
    problem = paper_problem(model, scaling=scaling)
    return theorem_quantities(
        problem.ingredients(), problem.state_weight, problem.input_weight, lipschitz, 10
    )


@pytest.mark.parametrize(
    ("model", "sigma", "xi", "contraction"),
    [("exact", 0.149721, 0.005138, 0.791010), ("paper", 0.151822, 0.005181, 0.787683)],
)
def test_quantities_of_the_models(model, sigma, xi, contraction):
    found = quantities(model)
    assert found.sigma == pytest.approx(sigma, abs=5e-7)
    assert found.xi == pytest.approx(xi, abs=5e-7)
    assert found.contraction == pytest.approx(contraction, abs=5e-7)


@pytest.mark.parametrize("scaling", [1.0, 2.5, 40.0])
@pytest.mark.parametrize("model", ["exact", "paper", "paper9"])
def test_squared_contraction_is_one_minus_rho_sigma(model, scaling):
    found = quantities(model, scaling=scaling)
    assert found.contraction**2 == pytest.approx(1.0 - scaling * found.sigma, abs=1e-12)


def test_weight_solves_28():
    problem = paper_problem()
    parts = problem.ingredients()
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    residual = parts.closed_loop.T @ parts.weight @ parts.closed_loop - parts.weight
    np.testing.assert_allclose(residual, -2.5 * star, atol=1e-10)
    np.testing.assert_array_equal(parts.weight, parts.weight.T)


@pytest.mark.parametrize("scaling", [1.0, 2.5, 40.0])
def test_condition_29_is_lipschitz_below_one_minus_contraction(scaling):
    edge = 1.0 - quantities("exact", scaling=scaling).contraction
    assert quantities("exact", 0.9999 * edge, scaling).theorem2.holds
    assert not quantities("exact", 1.0001 * edge, scaling).theorem2.holds


def test_condition_41_tends_to_29_as_rho_grows():
    found = quantities("exact", scaling=1e7)
    second = largest_lipschitz(found.contraction, found.theorem2.left)
    third = largest_lipschitz(found.contraction, found.theorem3.left)
    assert third == pytest.approx(second, rel=1e-4)


def test_largest_lipschitz_makes_the_condition_an_equality():
    found = quantities("exact")
    edge = largest_lipschitz(found.contraction, found.theorem3.left)
    condition = quantities("exact", edge).theorem3
    assert condition.left == pytest.approx(condition.right, rel=1e-12)


def test_c_2_of_a_short_horizon_is_the_sum_written_out():
    assert c_2(0.3, 0.5, 3) == pytest.approx(0.3 + 0.3 * 0.5 + 0.5**2)


def test_quantities_with_the_printed_matrix():
    from uav_tracking_mpc.studies.stability.printed import PRINTED_A, PRINTED_B

    problem = paper_problem()
    parts = terminal_ingredients(
        PRINTED_A, PRINTED_B, problem.state_weight, problem.input_weight, 2.5
    )
    found = theorem_quantities(parts, problem.state_weight, problem.input_weight, 0.5265, 10)
    assert found.sigma == pytest.approx(0.14917, abs=5e-6)
    assert found.xi == pytest.approx(0.004835, abs=5e-7)
    assert found.contraction == pytest.approx(0.79189, abs=5e-6)
    assert found.theorem3.left == pytest.approx(0.22859, abs=5e-6)
    assert found.theorem3.right == pytest.approx(1.1111, abs=5e-5)
    assert not found.theorem3.holds
