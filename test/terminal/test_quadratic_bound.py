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

"""Boxes: tests never confirm what samples refute, and confirm what has room."""

import numpy as np
import pytest

from uav_tracking_mpc.studies.stability.proof import decrease, verdicts
from uav_tracking_mpc.terminal.ingredients import decrease_excess, paper_problem

PROBLEM = paper_problem()
PARTS = PROBLEM.ingredients()
# m, rad, m, rad, m/s: where the decrease is just large enough
EDGE = np.array([-18.71966435, 2.4207043, 1.35483543, -0.31072763, -0.1027092])


@pytest.fixture(scope="module")
def excess():
    return decrease_excess(PROBLEM, PARTS)


def proved(bound, center, half):
    return verdicts(bound, center, half, np.zeros(len(center)))[0]


def test_verdicts_on_random_boxes_agree_with_samples(excess):
    """Levels far beyond the true limit: many boxes must fail, none may be wrong."""
    level = 18.0
    bound = decrease(PROBLEM, PARTS, level)
    root = bound.root()
    generator = np.random.default_rng(0)
    half = root * 2.0 ** -generator.integers(2, 6, (150, 5))
    center = generator.uniform(-0.9, 0.9, (150, 5)) * root
    good = proved(bound, center, half)
    for c, h in zip(center[good], half[good], strict=True):
        x = c + h * generator.uniform(-1.0, 1.0, (400, 5))
        inside = np.einsum("ki,ij,kj->k", x, PARTS.weight, x) <= level
        assert not np.any(excess(x[inside]) > 0.0)
    assert 10 < good.sum() < 150


def test_small_box_at_the_origin_is_proved():
    bound = decrease(PROBLEM, PARTS, 1.0)
    assert proved(bound, np.zeros((1, 5)), 0.05 * bound.root()[None])


def test_box_about_a_known_violation_is_never_proved(excess):
    bound, state = decrease(PROBLEM, PARTS, 16.5), 1.01 * EDGE
    assert excess(state[None])[0] > 0.0
    assert bound.violated_at(state)
    sizes = np.array([[1e-1], [1e-3], [1e-6]])
    assert not proved(bound, np.tile(state, (3, 1)), sizes * bound.root()).any()


@pytest.mark.parametrize(("level", "share"), [(15.0, 1.01), (16.5, 0.5)])
def test_a_state_beyond_the_level_or_within_the_bound_is_no_violation(level, share):
    assert not decrease(PROBLEM, PARTS, level).violated_at(share * EDGE)


def test_a_box_on_which_the_model_has_no_value_is_not_proved():
    bound = decrease(PROBLEM, PARTS, 1.0)
    center = np.array([[-150.0, 0.0, -50.0, 0.0, 0.0]])  # r = 0
    assert not proved(bound, center, np.ones((1, 5)))


def test_root_box_holds_the_ellipsoid_and_can_be_halved():
    root = decrease(PROBLEM, PARTS, 2.0).root()
    reach = np.sqrt(2.0 * np.diag(np.linalg.inv(PARTS.weight)))
    assert np.all(root > reach)
    assert np.all(root < reach * (1.0 + 1e-6))
    mantissa, _ = np.frexp(root)
    np.testing.assert_array_equal(mantissa * 2.0**24, np.round(mantissa * 2.0**24))
