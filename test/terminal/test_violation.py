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

"""Search for violations: what it finds breaks the bound indeed."""

import numpy as np
import pytest

from uav_tracking_mpc.terminal.stability_problem import paper_problem
from uav_tracking_mpc.terminal.theorems import q_star
from uav_tracking_mpc.terminal.violation import Excess, directions, largest_ratio, lowest_violation


def excess_of(model):
    problem = paper_problem(model)
    parts = problem.ingredients()
    star = q_star(problem.state_weight, problem.input_weight, parts.gain)
    return Excess(problem.dynamics(), parts.gain, parts.weight, parts.weight - star), parts


@pytest.mark.parametrize(("model", "level"), [("exact", 15.84), ("paper", 4.887)])
def test_lowest_violation_of_the_decrease(model, level):
    excess, parts = excess_of(model)
    found = lowest_violation(excess, 18.0)
    assert found.level == pytest.approx(level, abs=5e-3)
    assert excess(found.state[None])[0] > 0.0
    assert found.state @ parts.weight @ found.state == pytest.approx(found.level)


def test_no_violation_where_there_is_none():
    excess, _ = excess_of("exact")
    assert lowest_violation(excess, 5.0) is None


def test_gradient_is_the_derivative():
    excess, _ = excess_of("exact")
    x = np.array([3.0, 0.4, -1.0, 0.2, 0.3])
    _, gradient = excess.with_gradient(x)
    for i in range(5):
        step = 1e-6 * np.eye(5)[i]
        slope = (excess((x + step)[None])[0] - excess((x - step)[None])[0]) / 2e-6
        assert gradient[i] == pytest.approx(slope, rel=1e-5, abs=1e-7)


def test_ratio_is_attained_and_grows_with_the_level():
    problem = paper_problem("paper")
    parts = problem.ingredients()
    excess = Excess(
        problem.dynamics(), parts.gain, parts.weight, 0.0 * parts.weight, parts.closed_loop
    )
    small, large = largest_ratio(excess, 1.0), largest_ratio(excess, 3.1733)
    assert small.level < large.level == pytest.approx(0.5178, abs=1e-4)
    height = large.state @ parts.weight @ large.state
    assert np.sqrt(excess(large.state[None])[0] / height) == pytest.approx(large.level)


def test_directions_lie_on_the_unit_level():
    weight = paper_problem().ingredients().weight
    states = directions(weight, 100, np.random.default_rng(0))
    np.testing.assert_allclose(np.einsum("ki,ij,kj->k", states, weight, states), 1.0)
