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

"""The autopilot's clock by ours: offset, jitter, restarts."""

import numpy as np
import pytest

from uav_tracking_mpc.links.mavlink.autopilot_clock import AutopilotClock

OFFSET = 1234.5  # s, autopilot's time minus ours


def exchange(clock, sent, there, back):
    clock.see_answer(sent, sent + there + OFFSET, sent + there + back)


@pytest.fixture
def clock():
    """After one quick answer."""
    clock = AutopilotClock()
    exchange(clock, 0.0, 0.01, 0.01)
    return clock


def test_nothing_is_known_at_first():
    with pytest.raises(ValueError, match="nothing is known"):
        AutopilotClock().ours(1.0)


def test_until_the_first_answer_the_least_delay_counts():
    clock = AutopilotClock()
    for time, delay in ((1.0, 0.05), (1.02, 0.02), (1.04, 0.2)):
        clock.see_stamp(time + OFFSET, time + delay)
    assert clock.ours(2.0 + OFFSET) == pytest.approx(2.02)


def test_the_quickest_round_trip_counts_and_its_half_bounds_the_error():
    clock, random = AutopilotClock(), np.random.default_rng(1)
    for sent in range(15):
        exchange(clock, float(sent), *random.uniform(0.001, 0.3, 2))
    exchange(clock, 20.0, 0.002, 0.004)
    assert clock.delay == pytest.approx(0.003)
    assert abs(clock.offset - OFFSET) <= clock.delay
    assert clock.ours(30.0 + OFFSET) == pytest.approx(30.0, abs=clock.delay)
    assert 0.01 < clock.jitter < 0.2


def test_an_answer_from_nowhere_changes_nothing(clock):
    before = clock.offset
    clock.see_answer(5.0, 5.0 + OFFSET, 4.0)  # it came before it was asked
    clock.see_answer(5.0, 5.0 + OFFSET, 9.0)  # after too long
    clock.see_answer(5.0, float("nan"), 5.1)
    clock.see_answer(5.0, 77.0, 5.01)  # of another boot
    assert clock.offset == before


def test_a_clock_that_has_fallen_behind_is_believed_again():
    clock, late = AutopilotClock(), 5.0  # s that the autopilot's clock stood still
    for sent in range(5):
        exchange(clock, float(sent), 0.01, 0.01)
    for number in range(50):
        clock.see_stamp(OFFSET - late + 10.0 + 0.02 * number, 10.0 + 0.02 * number)
    for sent in (10.0, 10.5, 11.0):
        clock.see_answer(sent, sent + 0.01 + OFFSET - late, sent + 0.02)
    assert clock.ours(OFFSET - late + 12.0) == pytest.approx(12.0)
    assert clock.restarts == 0


def test_a_restart_is_seen_from_stamps_that_agree(clock):
    clock.see_stamp(OFFSET + 0.9, 0.95)
    for arrival in (1.0, 1.02, 1.04):
        assert clock.restarts == 0
        clock.see_stamp(arrival - 0.9, arrival)
    assert clock.restarts == 1
    assert clock.ours(0.14) == pytest.approx(1.04)


@pytest.mark.parametrize(
    "stamps", [(0.5, OFFSET + 1.0, 0.5, OFFSET + 2.0), (0.5, 70.0, 0.5, 300.0)]
)
def test_old_repeats_and_nonsense_do_not_restart_it(clock, stamps):
    for arrival, stamp in enumerate(stamps):
        clock.see_stamp(stamp, float(arrival))
    assert clock.restarts == 0


def test_telemetry_may_be_late(clock):
    for number in range(100):  # what waited for a minute while we were stopped
        clock.see_stamp(OFFSET + 0.1 * number, 60.0 + 1e-4 * number)
    assert clock.restarts == 0
