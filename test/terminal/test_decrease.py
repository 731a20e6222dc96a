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

"""Online check of the decrease (54)."""

import numpy as np
import pytest

from uav_tracking_mpc.terminal.decrease import DecreaseMonitor
from uav_tracking_mpc.terminal.ingredients import paper_problem

PROBLEM, LEVEL = paper_problem(), 2.8
WEIGHT = PROBLEM.ingredients().weight
X = np.array([np.sqrt(LEVEL / WEIGHT[0, 0]), 0.0, 0.0, 0.0, 0.0])  # on the edge of X_f
FALL = 0.005138 * LEVEL  # xi |x|^2


@pytest.mark.parametrize(
    ("final", "fall", "moved", "reason"),
    [
        (0.9, 1.01 * FALL, False, ""),
        (0.9, 0.99 * FALL, False, "unknown"),
        (0.9, -1.0, True, "target"),
        (1.1, -1.0, False, "terminal set not reached"),
    ],
)
def test_a_decrease_is_compared_with_the_bound_and_a_failure_is_counted_and_explained(
    final, fall, moved, reason
):
    check = DecreaseMonitor(PROBLEM, LEVEL)
    assert check.step(0.1, X, final * X) is None  # there is nothing to compare with
    answer = check.step(0.1 - fall, X, final * X, target_moved=moved)
    assert answer.held == (reason == "")
    assert answer.reason.startswith(reason)
    assert (check.checked, check.failed) == (1, not answer.held)


def test_a_step_without_a_cost_breaks_the_chain():
    check = DecreaseMonitor(PROBLEM, LEVEL)
    check.step(5.0, X)
    assert check.step(float("nan"), X) is None
    assert check.step(9.0, X) is None
    check.reset()
    assert check.step(9.0, X) is None
