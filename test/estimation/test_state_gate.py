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
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.estimation.measurement import SILENT, Measurement, SensorNoise
from uav_tracking_mpc.estimation.state_gate import AGREEING, REPEATING, StateGate, Verdict

TICK = 0.05  # s
HERE = np.zeros(3)


def measurement(stamp, position=HERE, noise=SILENT):
    return Measurement(stamp, position, np.zeros(3), 0.0, 0.0, noise=noise)


def judged(gate, steps, position=HERE, begin=10.0):
    """Verdicts on states whose stamps are so many ticks after the begin."""
    return [gate.judge(measurement(begin + step * TICK, position)) for step in steps]


@pytest.fixture
def gate():
    gate = StateGate(0.5)
    assert judged(gate, range(5)) == [Verdict.USE] * 5
    return gate


def test_duplicates_and_what_comes_out_of_order_are_dropped(gate):
    assert judged(gate, [4, 3, 1]) == [Verdict.DROP] * 3
    assert judged(gate, [5]) == [Verdict.USE]


def test_a_state_that_only_repeats_itself_tells_nothing_until_it_moves_on():
    gate = StateGate(0.5)

    def moving(stamp, place):
        return Measurement(stamp, np.array([20.0 * place, 0.0, 0.0]), np.full(3, 20.0), 1.0, 0.1)

    for stamp in np.arange(9.2, 9.99, TICK):
        assert gate.judge(moving(stamp, -0.05), stamp) is Verdict.USE  # it has never moved
    for stamp in np.arange(10.0, 15.0, TICK):
        used = Verdict.USE if stamp < 10.0 + REPEATING - 1e-6 else Verdict.DROP
        assert gate.judge(moving(stamp, 0.0), stamp) is used
    assert gate.newest.stamp == pytest.approx(
        10.0 + REPEATING, abs=1.1 * TICK
    )  # who watches: the state is lost
    assert gate.lost
    gate.check_target(15.0, 14.9, 5.0)
    assert gate.judge(moving(15.0, 5.0), 15.0) is Verdict.USE


@pytest.mark.parametrize("flown", [0.0, 20.0])
def test_a_place_that_stood_is_left_without_a_jump(flown):
    """By an aircraft that waited for its first command, or whose position was not measured."""
    gate, speed = StateGate(0.5), 20.0
    for stamp in np.arange(0.0, 10.0, TICK):
        gate.judge(Measurement(stamp, HERE, [speed, 0.0, 0.0], stamp, 0.0), stamp)
    there = [10.0 * flown + speed * TICK, 0.0, 0.0]
    verdict = gate.judge(Measurement(10.0, there, [speed, 0.0, 0.0], 10.0, 0.0), 10.0)
    assert verdict is Verdict.USE


@pytest.mark.parametrize("away", [-100, 1000])
def test_one_odd_stamp_is_doubted_and_flight_goes_on(gate, away):
    assert judged(gate, [away, 5, away + 7, away + 8, 6, 7]) == [
        Verdict.DOUBT, Verdict.USE, Verdict.DOUBT, Verdict.DOUBT, Verdict.USE, Verdict.USE,
    ]  # fmt: skip
    assert "stamp went" in gate.reason


def test_a_clock_that_went_back_is_believed_when_states_agree(gate):
    doubts = [Verdict.DOUBT] * (AGREEING - 1)
    verdicts = judged(gate, range(-100, -100 + AGREEING + 2))
    assert verdicts == [*doubts, Verdict.RESTART, Verdict.USE, Verdict.USE]


def test_after_a_gap_flight_goes_on_without_a_new_beginning(gate):
    verdicts = judged(gate, range(60, 60 + AGREEING + 1))
    assert verdicts == [Verdict.DOUBT] * (AGREEING - 1) + [Verdict.USE] * 2


@pytest.mark.parametrize("gap", [2.0, 14.0, 60.0])
def test_a_gap_that_the_clock_has_seen_too_is_no_doubt(gap):
    """Nor is it a jump to be where 22 m/s lead."""

    def flown(time):
        return Measurement(10.0 + time, [22.0 * time, 0, 0], [22.0, 0, 0], 0.0, 0.0)

    gate = StateGate(0.5)
    gate.judge(flown(0.25), 1000.25)
    assert gate.judge(flown(0.25 + gap), 1000.3 + gap) is Verdict.USE


@pytest.mark.parametrize("gap", [14.0, 60.0])
def test_a_gap_of_a_flight_is_no_jump_without_a_clock_either(gap):
    gate = StateGate(0.5)
    for time in (0.0, gap, gap + 0.05, gap + 0.1):
        verdict = gate.judge(Measurement(time, [22.0 * time, 0, 0], [22.0, 0, 0], 0.0, 0.0))
    assert verdict is Verdict.USE
    assert "stamp went ahead" in gate.reason


def test_a_stamp_that_goes_ahead_of_the_clock_is_doubted():
    gate = StateGate(0.5)
    gate.judge(measurement(10.25), 1000.25)
    assert gate.judge(measurement(20.25), 1000.3) is Verdict.DOUBT


def test_a_teleport_is_a_new_beginning_when_states_agree(gate):
    there = np.array([5e3, 0.0, 0.0])
    assert judged(gate, [5], there) == [Verdict.DOUBT]
    assert "position jumped by 5000 m" in gate.reason
    assert judged(gate, [6]) == [Verdict.USE]
    verdicts = judged(gate, range(7, 7 + AGREEING), there)
    assert verdicts == [Verdict.DOUBT] * (AGREEING - 1) + [Verdict.RESTART]


def test_what_the_noise_explains_is_no_jump(gate):
    there = np.array([100.0, 0.0, 0.0])
    assert gate.judge(measurement(10.25, there)) is Verdict.DOUBT
    assert gate.judge(measurement(10.25, there, SensorNoise(position=(20.0,) * 3))) is Verdict.USE


@given(st.lists(st.tuples(st.floats(-1e10, 1e10), st.floats(-1e7, 1e7)), max_size=30))
def test_used_stamps_rise_but_for_a_restart(states):
    gate, newest = StateGate(0.5), None
    for stamp, x in states:
        verdict = gate.judge(measurement(stamp, np.array([x, 0.0, 0.0])))
        if verdict is Verdict.USE:
            assert newest is None or stamp > newest
        if verdict in (Verdict.USE, Verdict.RESTART):
            newest = stamp
