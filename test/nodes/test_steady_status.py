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

"""What is shown of a status that may change with every message."""

import pytest

from uav_tracking_mpc.nodes.steady_status import LASTING, SteadyStatus

OK, WARN, ERROR = b"\x00", b"\x01", b"\x02"
TICK = 0.05


def shown(*script):
    """Each change that is shown of (levels in turn, seconds), every 50 ms after a fine time."""
    status, now, seen = SteadyStatus(WARN, "starting"), 0.0, []
    for levels, seconds in ((OK, 10.0), *script):
        for tick in range(round(seconds / TICK)):
            level = levels[tick % len(levels) :][:1]
            if status.see(level, f"level {level[0]}", now):
                seen.append(level)
            now += TICK
    return seen


def test_at_the_start_every_change_is_shown():
    status = SteadyStatus(WARN, "starting")
    for tick, words in enumerate(("waiting for one", "waiting for another")):
        assert status.see(WARN, words, 0.01 * tick)
        assert status.message == words
    assert status.see(OK, "flying", 0.03)


def test_an_error_at_the_start_is_shown_once_however_often_it_comes_and_goes():
    """As on a machine that plans too slowly until the solver is compiled."""
    status = SteadyStatus(WARN, "starting")
    told = [status.see((WARN, ERROR)[tick % 2], "slow", TICK * tick) for tick in range(600)]
    assert sum(told) <= 2
    assert status.level == ERROR


@pytest.mark.parametrize("worse", [WARN, ERROR])
def test_what_alternates_twenty_times_a_second_is_shown_as_its_worse_half(worse):
    assert shown((worse + OK, 30.0)) == [OK, worse]


def test_a_better_status_is_shown_when_it_has_lasted():
    assert shown((WARN + OK, 1.0), (OK, LASTING - 0.2)) == [OK, WARN]
    assert shown((WARN + OK, 1.0), (OK, LASTING + 0.2)) == [OK, WARN, OK]


def test_a_worse_status_is_shown_at_once_and_one_that_stood_ends_at_once():
    assert shown((ERROR, TICK)) == [OK, ERROR]
    assert shown((ERROR, LASTING + 0.2), (OK, TICK)) == [OK, ERROR, OK]


def test_two_that_are_better_may_alternate():
    """The bad one is over all the same."""
    assert shown((ERROR, 0.1), (OK + WARN, 3 * LASTING)) in (
        [OK, ERROR, WARN],
        [OK, ERROR, OK, WARN],
    )


def test_what_somebody_asked_for_is_shown_at_once():
    status = SteadyStatus(WARN, "starting")
    status.see(OK, "flying", 0.0)
    status.see(ERROR, "lost", 0.1)
    status.begin(WARN, "inactive")
    assert (status.level, status.message) == (WARN, "inactive")
    assert status.see(OK, "flying", 0.2)
