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

from uav_tracking_mpc.terminal.decrease import DecreaseMonitor, decrease_monitor
from uav_tracking_mpc.terminal.ingredients import paper_problem

X = np.array([1.0, 0.0, 0.0, 0.0, 0.0])


def monitor():
    return DecreaseMonitor(0.1, np.eye(5), level=1.0)


def test_first_step_has_nothing_to_compare_with():
    assert monitor().step(5.0, X) is None


def test_decrease_by_the_bound_holds():
    check = monitor()
    check.step(5.0, X)
    answer = check.step(4.9, X)
    assert answer.held
    assert answer.bound == 4.9
    assert answer.reason == ""


def test_too_small_a_decrease_fails_and_is_counted():
    check = monitor()
    check.step(5.0, X, 0.1 * X)
    answer = check.step(4.95, X, 0.1 * X)
    assert not answer.held
    assert answer.reason.startswith("unknown")
    assert (check.checked, check.failed) == (1, 1)


def test_reasons_when_known():
    check = monitor()
    check.step(5.0, X, 0.1 * X)
    assert "target" in check.step(6.0, X, 0.1 * X, target_moved=True).reason
    check = monitor()
    check.step(5.0, X, 9.0 * X)
    assert "terminal set not reached" in check.step(6.0, X, 9.0 * X).reason


def test_a_step_without_a_cost_breaks_the_chain():
    check = monitor()
    check.step(5.0, X)
    assert check.step(float("nan"), X) is None
    assert check.step(9.0, X) is None
    check.reset()
    assert check.step(9.0, X) is None


def test_rate_of_a_configuration_is_xi():
    assert abs(decrease_monitor(paper_problem(), 2.8).rate - 0.005138) < 1e-6
