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
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.estimation.navigator import CommandHistory

PLAN = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])


def test_before_the_first_command_nothing_is_demanded():
    history = CommandHistory(1.0)
    assert history.demanded(3.0, 0) == 0.0
    history.add(5.0, 5.0, PLAN, 0.5)
    assert [history.demanded(4.99, axis) for axis in range(3)] == [0.0, 0.0, 0.0]


def test_a_plan_is_flown_segment_by_segment_and_its_end_is_held():
    history = CommandHistory(1.0)
    history.add(5.0, 5.0, PLAN, 0.5)
    demanded = [history.demanded(time, 1) for time in (5.0, 5.49, 5.5, 5.99, 6.0, 60.0)]
    assert demanded == [0.2, 0.2, 0.5, 0.5, 0.5, 0.5]


def test_the_newest_plan_of_a_time_counts():
    history = CommandHistory(1.0)
    history.add(5.0, 5.0, PLAN, 0.5)
    history.add(5.2, 5.2, PLAN + 1.0, 0.5)
    assert history.demanded(5.1, 0) == 0.1
    assert history.demanded(5.2, 0) == 1.1


def test_a_plan_that_was_sent_late_is_flown_from_then_on_where_it_has_got_to():
    """Its segments are laid out from its stamp, not from when it arrived."""
    history = CommandHistory(1.0)
    history.add(5.0, 5.0, PLAN, 0.5)
    history.add(5.4, 5.1, PLAN + 1.0, 0.5)
    demanded = [history.demanded(time, 0) for time in (5.39, 5.41, 5.59, 5.61)]
    assert demanded == [0.1, 1.1, 1.1, 1.4]


@given(
    st.lists(st.tuples(st.floats(0.01, 2.0), st.floats(-1.0, 1.0)), min_size=1, max_size=50),
    st.floats(0.0, 2.0),
    st.floats(0.0, 1.0),
)
def test_within_its_memory_it_is_as_one_that_forgets_nothing(steps, memory, share):
    history, everything = CommandHistory(memory), CommandHistory(np.inf)
    now = 0.0
    for step, value in steps:
        now += step
        for kept in (history, everything):
            kept.add(now, now, np.full((1, 3), value), 1.0)
    asked = now - share * memory
    assert history.demanded(asked, 2) == everything.demanded(asked, 2)
    assert len(history._plans) <= memory / 0.01 + 2


def test_a_clock_that_stood_ahead_leaves_nothing_behind():
    """While it stood ahead a plan was sent in the future; later ones must not pile up behind it."""
    history = CommandHistory(1.0)
    history.add(3600.0, 5.0, PLAN, 0.5)
    for k in range(1000):
        history.add(5.0 + 0.05 * k, 5.0 + 0.05 * k, PLAN + k, 0.5)
    assert len(history._plans) < 30
    assert history.demanded(5.0 + 0.05 * 999, 0) == 0.1 + 999
