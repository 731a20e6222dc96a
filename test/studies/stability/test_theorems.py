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

"""Theorem quantities against independent values and identities; violations that break the bound."""

import numpy as np
import pytest

from uav_tracking_mpc.studies.stability.analysis import (
    largest_lipschitz,
    largest_ratio,
    lipschitz_excess,
    lowest_violation,
    theorem2,
    theorem3,
    theorem_quantities,
)
from uav_tracking_mpc.studies.stability.paper_report import PRINTED_LIPSCHITZ, paper_cases
from uav_tracking_mpc.terminal.ingredients import decrease_excess, directions, paper_problem


def quantities(model, lipschitz=0.5265, scaling=2.5, horizon=10):
    problem = paper_problem(model, scaling=scaling, horizon=horizon)
    return theorem_quantities(problem, problem.ingredients(), lipschitz)


@pytest.mark.parametrize(
    ("model", "sigma", "xi", "contraction"),
    [("exact", 0.149721, 0.005138, 0.791010), ("paper", 0.151822, 0.005181, 0.787683)],
)
def test_quantities_of_the_models(model, sigma, xi, contraction):
    found, expected = quantities(model), {"sigma": sigma, "xi": xi, "contraction": contraction}
    assert {name: found[name] for name in expected} == pytest.approx(expected, abs=5e-7)


@pytest.mark.parametrize("scaling", [1.0, 2.5, 40.0])
@pytest.mark.parametrize("model", ["exact", "paper", "paper9"])
def test_squared_contraction_is_one_minus_rho_sigma(model, scaling):
    found = quantities(model, scaling=scaling)
    assert found["contraction"] ** 2 == pytest.approx(1.0 - scaling * found["sigma"], abs=1e-12)


@pytest.mark.parametrize("scaling", [1.0, 2.5, 40.0])
def test_condition_29_is_lipschitz_below_one_minus_contraction(scaling):
    edge = 1.0 - quantities("exact", scaling=scaling)["contraction"]
    assert theorem2(quantities("exact", 0.9999 * edge, scaling))["holds"]
    assert not theorem2(quantities("exact", 1.0001 * edge, scaling))["holds"]


def edge(found, theorem):
    return largest_lipschitz(found["contraction"], theorem(found)["left"])


def test_condition_41_tends_to_29_as_rho_grows():
    found = quantities("exact", scaling=1e7)
    assert edge(found, theorem3) == pytest.approx(edge(found, theorem2), rel=1e-4)


def test_largest_lipschitz_makes_the_condition_an_equality():
    condition = theorem3(quantities("exact", edge(quantities("exact"), theorem3)))
    assert condition["left"] == pytest.approx(condition["right"], rel=1e-12)


def test_c_2_of_a_short_horizon_is_the_sum_written_out():
    found = quantities("exact", horizon=3)
    eta, tau = found["eta"], found["tau"]
    assert found["c_2"] == pytest.approx(eta + eta * tau + tau**2)


def test_quantities_with_the_printed_matrix():
    printed, *_ = paper_cases()
    found = printed.quantities(PRINTED_LIPSCHITZ)
    expected = {"sigma": 0.14917, "xi": 0.004835, "contraction": 0.79189}
    assert {name: found[name] for name in expected} == pytest.approx(expected, abs=5e-6)
    assert theorem3(found)["left"] == pytest.approx(0.22859, abs=5e-6)
    assert theorem3(found)["right"] == pytest.approx(1.1111, abs=5e-5)
    assert not theorem3(found)["holds"]


def excess_of(model):
    problem = paper_problem(model)
    parts = problem.ingredients()
    return decrease_excess(problem, parts), parts


@pytest.mark.parametrize(("model", "level"), [("exact", 15.84), ("paper", 4.887)])
def test_lowest_violation_of_the_decrease_and_none_where_there_is_none(model, level):
    excess, parts = excess_of(model)
    found = lowest_violation(excess, 18.0)
    assert found.level == pytest.approx(level, abs=5e-3)
    assert excess(found.state[None])[0] > 0.0
    assert found.state @ parts.weight @ found.state == pytest.approx(found.level)
    assert lowest_violation(excess, 0.9 * level) is None


def test_gradient_is_the_derivative():
    excess, _ = excess_of("exact")
    x = np.array([3.0, 0.4, -1.0, 0.2, 0.3])
    _, gradient = excess.with_gradient(x)
    steps = 1e-6 * np.eye(5)
    np.testing.assert_allclose(gradient, (excess(x + steps) - excess(x - steps)) / 2e-6, rtol=1e-5)


def test_ratio_is_attained_and_grows_with_the_level():
    problem = paper_problem("paper")
    parts = problem.ingredients()
    excess = lipschitz_excess(problem, parts, 0.0)
    small, large = largest_ratio(excess, 1.0), largest_ratio(excess, 3.1733)
    assert small.level < large.level == pytest.approx(0.5178, abs=1e-4)
    height = large.state @ parts.weight @ large.state
    assert np.sqrt(excess(large.state[None])[0] / height) == pytest.approx(large.level)


def test_directions_lie_on_the_unit_level():
    weight = paper_problem().ingredients().weight
    states = directions(weight, 100, np.random.default_rng(0))
    np.testing.assert_allclose(np.einsum("ki,ij,kj->k", states, weight, states), 1.0)
