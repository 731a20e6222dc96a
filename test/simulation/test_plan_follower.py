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

import numpy as np
import pytest

from uav_tracking_mpc.simulation.plan_follower import PlanFollower

PRESENT = [[0.1, 0.0, 0.0]]


@pytest.fixture
def follower():
    """At 0.5 s, with a plan that began then."""
    follower = PlanFollower()
    follower.accept(PRESENT, [0.5], now=0.5)
    return follower


def test_segments_follow_each_other_and_the_last_is_as_long_as_the_one_before():
    follower = PlanFollower()
    assert follower.inputs(0.0) is None  # waiting for the first plan is no failsafe
    assert (follower.commanded, follower.holding, follower.failsafes) == (False, True, 0)
    follower.accept([[0.1, 0, 0], [0.2, 0, 0]], [1.0, 1.5], now=0.8)
    asked = [follower.inputs(time) for time in (0.8, 1.0, 1.49, 1.5, 1.99)]
    assert [inputs[0] for inputs in asked] == [0.1, 0.1, 0.1, 0.2, 0.2]
    assert not follower.holding
    assert follower.inputs(2.0) is None


def test_the_end_of_a_plan_is_counted_once(follower):
    assert [follower.inputs(time) is None for time in (1.4, 1.5, 1.6)] == [False, True, True]
    assert (follower.holding, follower.failsafes) == (True, 1)


@pytest.mark.parametrize(
    ("plan", "starts", "words"),
    [
        ([[np.nan, 0, 0]], [0.6], "not finite"),
        ([[0, 0, 0]], [np.inf], "not finite"),
        ([], [], r"shape \(0,\)"),
        ([[0, 0]], [0.6], r"shape \(1, 2\)"),
        ([[0, 0, 0]] * 2, [1.0], r"a start for each"),
        ([[0, 0, 0]] * 2, [1.0, 1.0], "not in order"),
        ([[0, 0, 0]], [3600.5], "begins 3600.000 s from now"),
        ([[0, 0, 0]], [0.4], "older"),
    ],
)
def test_a_bad_plan_is_refused_and_the_present_one_stays(follower, plan, starts, words):
    with pytest.raises(ValueError, match=words):
        follower.accept(plan, starts, now=0.5)
    np.testing.assert_array_equal(follower.inputs(0.5), PRESENT[0])


def test_a_plan_is_kept_as_it_was_given():
    given, follower = np.array(PRESENT), PlanFollower()
    follower.accept(given, [0.0], now=0.0)
    given[:] = 9.0
    np.testing.assert_array_equal(follower.inputs(0.0), PRESENT[0])


@pytest.mark.parametrize("delay", [0.0, 0.3])
def test_after_the_clock_went_back_the_plan_of_then_is_none(delay):
    follower = PlanFollower(delay)
    follower.accept(PRESENT, [100.0], now=100.0)
    assert follower.inputs(100.4) is not None
    assert follower.inputs(10.0) is None  # and not its first segment for a minute and a half
    follower.accept([[0.3, 0.0, 0.0]], [10.0], now=10.0)
    assert follower.inputs(10.4)[0] == 0.3


def test_a_delayed_plan_is_flown_so_much_later_and_the_one_before_until_then():
    follower = PlanFollower(delay=0.3)
    follower.accept([[0.1, 0.0, 0.0]], [0.0], now=0.0)
    assert follower.inputs(0.2) is None
    follower.accept([[0.2, 0.0, 0.0], [0.4, 0.0, 0.0]], [0.1, 0.5], now=0.1)
    assert [follower.inputs(now)[0] for now in (0.3, 0.39, 0.4, 0.79, 0.8)] == [
        0.1, 0.1, 0.2, 0.2, 0.4,
    ]  # fmt: skip
    follower.delay = 0.0
    follower.accept([[0.5, 0.0, 0.0]], [0.9], now=0.9)
    assert follower.inputs(0.9)[0] == 0.5


def test_a_plan_that_was_overtaken_on_its_way_is_refused():
    follower = PlanFollower(delay=0.3)
    follower.accept([[0.2, 0.0, 0.0]], [1.0], now=1.0)
    with pytest.raises(ValueError, match="older than one that has come before"):
        follower.accept([[0.1, 0.0, 0.0]], [0.9], now=1.05)
    assert follower.inputs(1.6)[0] == 0.2
