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

"""One box: tests never claim what samples refute, and prove what has room."""

import numpy as np
import pytest

flint = pytest.importorskip("flint")

from uav_tracking_mpc.terminal.box_check import BoxTest, is_positive_definite, short_upper  # noqa: E402
from uav_tracking_mpc.terminal.direct_condition import decrease  # noqa: E402
from uav_tracking_mpc.terminal.quadratic_bound import exact  # noqa: E402
from uav_tracking_mpc.terminal.stability_problem import paper_problem  # noqa: E402
from uav_tracking_mpc.terminal.theorems import q_star  # noqa: E402
from uav_tracking_mpc.terminal.violation import Excess  # noqa: E402

PROBLEM = paper_problem()
PARTS = PROBLEM.ingredients()


@pytest.fixture(scope="module")
def excess():
    star = q_star(PROBLEM.state_weight, PROBLEM.input_weight, PARTS.gain)
    return Excess(PROBLEM.dynamics(), PARTS.gain, PARTS.weight, PARTS.weight - star)


def test_verdicts_on_random_boxes_agree_with_samples(excess):
    """Levels far beyond the true limit: many boxes must fail, none may be wrong."""
    level = 18.0
    test = BoxTest(decrease(PROBLEM, PARTS, level))
    root = test.root()
    generator = np.random.default_rng(0)
    proved = wrong = 0
    for _ in range(150):
        half = root * 2.0 ** -generator.integers(2, 6, 5)
        center = generator.uniform(-0.9, 0.9, 5) * root
        if test(center, half).proved:
            proved += 1
            x = center + half * generator.uniform(-1.0, 1.0, (400, 5))
            inside = np.einsum("ki,ij,kj->k", x, PARTS.weight, x) <= level
            wrong += bool(np.any(excess(x[inside]) > 0.0)) if inside.any() else 0
    assert wrong == 0
    assert proved > 10


def test_small_box_at_the_origin_is_proved():
    test = BoxTest(decrease(PROBLEM, PARTS, 1.0))
    assert test(np.zeros(5), 0.05 * test.root()).proved


def test_box_about_a_known_violation_is_never_proved(excess):
    state = np.array([-18.71966435, 2.4207043, 1.35483543, -0.31072763, -0.1027092])
    test = BoxTest(decrease(PROBLEM, PARTS, 16.5))
    state = 1.01 * state
    assert excess(state[None])[0] > 0.0
    for size in (1e-1, 1e-3, 1e-6):
        assert not test(state, size * test.root()).proved


def test_root_box_holds_the_ellipsoid():
    test = BoxTest(decrease(PROBLEM, PARTS, 2.0))
    reach = np.sqrt(2.0 * np.diag(np.linalg.inv(PARTS.weight)))
    assert np.all(test.root() > reach)
    assert np.all(test.root() < reach * (1.0 + 1e-6))


def test_definiteness():
    assert is_positive_definite(exact(np.diag([1.0, 2.0])))
    assert not is_positive_definite(exact(np.diag([1.0, -2.0])))
    assert not is_positive_definite(exact(np.array([[1.0, 1.0], [1.0, 1.0]])))
    wide = exact(np.eye(2))
    wide[0, 1] = wide[1, 0] = flint.arb(0, 1.5)
    assert not is_positive_definite(wide)


def test_short_upper_is_short_and_above():
    value = short_upper(flint.arb(2).sqrt())
    assert 2.0**0.5 < value < 2.0**0.5 * (1.0 + 1e-6)
    assert np.ldexp(value, 24) == int(np.ldexp(value, 24))
