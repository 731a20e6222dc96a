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

"""Positions and ground velocities that fail are left out; air that changes is believed."""

import math

import numpy as np
import pytest
from evaluated_check import Evaluated

from uav_tracking_mpc.estimation.motion_check import (
    ASTRAY,
    BY_WIND,
    CONTRARY_TIME,
    DEVIATIONS,
    JUMP,
    JUMP_TIME,
    ODD,
    POSITION_CHECK,
    STALE,
    STANDING,
    VELOCITY_CHECK,
    WINDOW,
    position_checked,
    velocity_checked,
)
from uav_tracking_mpc.estimation.sensor_health import STATES
from uav_tracking_mpc.estimation.wind_filter import FOLLOWER, followed

STEP = 0.05
VELOCITY_STEP = 0.1
EXPECTED = np.array([20.0, 0.0, 0.0])
ODD_ONE = np.add(EXPECTED, (0.0, 2.0 * ODD, 0.0))
USED, LEFT_OUT, NEW = (0, 0), (1, 0), (0, 1)


def velocity_check(position, velocity):
    memory = np.zeros(VELOCITY_CHECK.size)
    known = VELOCITY_CHECK.parts(memory)
    known.begin[:], known.before[:] = position, velocity
    return Evaluated(velocity_checked, VELOCITY_CHECK, memory, [1, 3, 1, 3, 3, 1, 1])


@pytest.fixture
def velocities():
    return velocity_check(np.zeros(3), EXPECTED)


def judged(check, flown, measured, duration, deviation=0.0):
    """Verdicts over a time in which one velocity is flown and one measured."""
    steps = range(round(duration / VELOCITY_STEP))
    found = (
        check(VELOCITY_STEP, k * VELOCITY_STEP * flown, 1.0, measured, EXPECTED, deviation, 0.1)
        for k in steps
    )
    return [(int(odd[0]), int(changed[0])) for odd, _, changed in found]


def test_a_velocity_that_is_near_is_used_and_one_that_is_uncertain_may_be_farther(velocities):
    near = np.add(EXPECTED, (0.9 * ODD, 0.0, 0.0))
    assert set(judged(velocities, near, near, 3.0)) == {USED}
    drifted = velocity_check(np.zeros(3), ODD_ONE)
    assert set(judged(drifted, EXPECTED, ODD_ONE, 3.0, deviation=ODD)) == {USED}


def test_a_velocity_that_is_suddenly_far_is_left_out_however_uncertain_the_air_is(velocities):
    assert set(judged(velocities, EXPECTED, ODD_ONE, 3.0, deviation=ODD)) == {LEFT_OUT}


def test_a_velocity_that_is_not_flown_stays_odd(velocities):
    assert set(judged(velocities, EXPECTED, ODD_ONE, 10.0 * WINDOW)) == {LEFT_OUT}


def test_a_velocity_that_is_flown_is_new_after_the_window(velocities):
    verdicts = judged(velocities, ODD_ONE, ODD_ONE, 2.0 * WINDOW)
    first = verdicts.index(NEW)
    assert set(verdicts[:first]) == {LEFT_OUT}
    assert abs(first * VELOCITY_STEP - WINDOW) < 2.0 * VELOCITY_STEP


def test_a_fault_that_turns_into_a_change_is_believed_at_last(velocities):
    assert NEW not in judged(velocities, EXPECTED, ODD_ONE, 3.5 * WINDOW)
    assert NEW in judged(velocities, ODD_ONE, ODD_ONE, 2.5 * WINDOW)


def test_an_odd_velocity_between_good_ones_is_forgotten(velocities):
    for _ in range(5):
        assert judged(velocities, EXPECTED, ODD_ONE, 0.5 * WINDOW)[-1] == LEFT_OUT
        assert judged(velocities, EXPECTED, EXPECTED, VELOCITY_STEP) == [USED]


def is_contrary(check, step, position, fresh, measured, noise):
    """Whether positions contradict a velocity that is as expected."""
    return bool(check(step, position, fresh, measured, measured, 0.0, noise)[1])


def contradicted(measured, duration, moved=lambda time: 0.0, fresh=True, check=None, begin=0.0):
    """Verdicts of flying to the East, with positions that are elsewhere; and the check."""
    if check is None:
        check = velocity_check(np.zeros(3), measured)
    found = []
    for k in range(1, round(duration / STEP)):
        time = begin + k * STEP
        position = time * EXPECTED + np.array([0.0, moved(time), 0.0])
        found.append(is_contrary(check, STEP, position, fresh, measured, 0.1))
    return found, check


@pytest.mark.parametrize(("off", "left_out"), [(0.0, False), (8.0, True)])
def test_a_velocity_is_contradicted_by_noisy_positions_too_but_not_by_noise(off, left_out):
    """By windows that last until noise hides it no more."""
    random, measured, noise = np.random.default_rng(3), np.add(EXPECTED, (0.0, off, 0.0)), 1.5
    check = velocity_check(np.zeros(3), measured)
    found = [
        is_contrary(
            check, STEP, k * STEP * EXPECTED + noise * random.standard_normal(3), True, measured,
            noise,
        )
        for k in range(1, round(60.0 / STEP))
    ]  # fmt: skip
    assert any(found) == left_out
    assert found[-1] == left_out


@pytest.mark.parametrize("gain", [-1.0, 0.0, 0.8, 1.2, 2.0])
def test_a_velocity_that_positions_contradict_for_seconds_is_left_out(gain):
    found, check = contradicted(gain * EXPECTED, 10.0)
    assert found.index(True) * STEP == pytest.approx(CONTRARY_TIME, abs=3.0 * STEP)
    assert all(found[found.index(True) :])
    again, _ = contradicted(EXPECTED, 3.0, check=check, begin=10.0)
    assert not any(again[round(2.0 * WINDOW / STEP) + 2 :])


@pytest.mark.parametrize(
    "moved",
    [
        lambda time: 0.0,
        lambda time: 8.0 * (time // 4.0),  # jumps
        lambda time: 10.0 * (time % 8.0 < 1.5),  # spikes
        lambda time: 2.0 * time,  # drifts
        lambda time: 0.1 * math.sin(37.0 * time),
    ],
)
def test_positions_that_fail_for_a_moment_contradict_no_velocity(moved):
    assert not any(contradicted(EXPECTED, 40.0, moved)[0])


@pytest.mark.parametrize(("gain", "wrong"), [(-1.0, True), (0.3, False), (1.0, False)])
@pytest.mark.parametrize("noise", [0.1, 1.0])
def test_a_vertical_velocity_of_the_other_sign_is_contradicted(gain, wrong, noise):
    """Though it may differ by less than 3 m/s, beside heights with noise and steps."""
    random, size = np.random.default_rng(0), 0.6 + 3.0 * noise
    check, found = velocity_check(np.zeros(3), np.array([22.0, 0.0, 0.0])), []
    for time in np.arange(STEP, 60.0, STEP):
        climb = size * math.sin(0.7 * time)
        height = size / 0.7 * (1.0 - math.cos(0.7 * time)) + 3.0 * (time % 20.0 > 10.0)
        position = np.array([22.0 * time, 0.0, height]) + noise * random.standard_normal(3)
        velocity = [22.0, 0.0, gain * climb]
        found.append(is_contrary(check, STEP, position, True, velocity, noise))
    assert found[-1] == wrong
    assert any(found) == wrong


@pytest.mark.parametrize("step", [0.02, 1.0])
def test_a_turn_that_is_seldom_measured_contradicts_nothing(step):
    check = velocity_check([0.0, -55.0, 0.0], [22.0, 0.0, 0.0])
    for k in range(1, round(30.0 / step)):
        angle = 0.4 * k * step
        position = 55.0 * np.array([math.sin(angle), -math.cos(angle), 0.0])
        velocity = 22.0 * np.array([math.cos(angle), math.sin(angle), 0.0])
        assert not is_contrary(check, step, position, True, velocity, 0.1)


def test_positions_that_repeat_themselves_contradict_nothing():
    assert not any(contradicted(2.0 * EXPECTED, 10.0, fresh=False)[0])


@pytest.mark.parametrize("step", [STEP, 2.0])
def test_positions_alone_tell_the_velocity_of_an_aircraft_that_turns(step):
    memory = np.zeros(FOLLOWER.size)
    check = Evaluated(followed, FOLLOWER, memory, [1, 3, 1, 3])
    wind = np.array([3.0, 0.0, 0.0])
    for k in range(round(40.0 / step)):
        angle = 0.25 * k * step
        position = 88.0 * np.array([math.sin(angle), -math.cos(angle), 0.0])
        velocity = 22.0 * np.array([math.cos(angle), math.sin(angle), 0.0])
        turning = 0.25 * np.array([-velocity[1], velocity[0], 0.0])
        (by_positions,) = check(step, position + k * step * wind, 1.0, turning)
    assert by_positions == pytest.approx(velocity + wind, abs=6.0 * step)


def placed(offset, duration, present=True):
    """States, whether they are used, and moves of positions that are elsewhere from the second."""
    check = Evaluated(
        position_checked, POSITION_CHECK, np.zeros(POSITION_CHECK.size), [1, 3, 1, 3, 1, 1, 1]
    )
    rows = []
    for k in range(1, round(duration / STEP)):
        carried = k * STEP * EXPECTED
        seen = carried + np.array([offset, 0.0, 0.0]) * (k > 1)
        code, place, _, moved, _ = check(STEP, seen, present, carried, EXPECTED[2], 0.1, 0.0)
        rows.append((STATES[int(code[0])], bool(present and (place == seen).all()), bool(moved[0])))
    return rows


@pytest.mark.parametrize("climb", [1.0, -1.0])
def test_a_height_that_stays_while_the_aircraft_climbs_is_stuck_until_it_changes(climb):
    zeros = np.zeros(POSITION_CHECK.size)
    check = Evaluated(position_checked, POSITION_CHECK, zeros, [1, 3, 1, 3, 1, 1, 1])
    carried, states = np.array([0.0, 0.0, 100.0]), []
    for k in range(round(6.0 / STEP)):
        carried += STEP * np.array([20.0, 0.0, climb])
        seen = [*carried[:2], 100.0 if k * STEP < 4.0 else carried[2]]
        code, place, *_ = check(STEP, seen, 1.0, carried, climb, 0.0, 0.0)
        states.append(STATES[int(code[0])])
        waits = not k or k * STEP * abs(climb) <= STANDING * JUMP
        assert waits or place == pytest.approx(carried)
    stuck = states.index("stuck")
    assert stuck * STEP == pytest.approx(JUMP, abs=3.0 * STEP)
    assert set(states[stuck : round(4.0 / STEP)]) == {"stuck"}
    assert set(states[:stuck] + states[round(4.0 / STEP) + 1 :]) == {"used"}


@pytest.mark.parametrize("between", [1.0, 0.0])  # it is repeated there, or left out
@pytest.mark.parametrize(("standing", "states"), [(False, {"used"}), (True, {"used", "stuck"})])
def test_a_height_that_is_seldom_measured_is_stuck_only_beside_new_places(
    standing, states, between
):
    zeros = np.zeros(POSITION_CHECK.size)
    check = Evaluated(position_checked, POSITION_CHECK, zeros, [1, 3, 1, 3, 1, 1, 1])
    carried, found = np.zeros(3), []
    for k in range(round(6.0 / STEP)):
        present = 1.0 if k % 20 == 0 else between  # every second
        if k % 20 == 0:
            seen = carried * [1.0, 1.0, not standing]
        code, *_ = check(STEP, seen, present, carried, 3.0, 0.0, 0.0)
        found.append(STATES[int(code[0])])
        carried += STEP * np.array([20.0, 0.0, 3.0])
    assert set(found) == states
    assert found[-1] == ("stuck" if standing else "used")


def test_a_position_that_jumps_is_left_out_until_it_has_stayed_there():
    rows = placed(2.0 * JUMP, 1.5 * JUMP_TIME)
    arrived = rows.index(("used", True, True))
    assert arrived * STEP == pytest.approx(JUMP_TIME, abs=2.0 * STEP)
    assert set(rows[1:arrived]) == {("jumped", False, False)}


def test_a_position_that_is_near_is_used_and_an_absent_one_is_silent():
    assert set(placed(0.5 * JUMP, 1.0)) == {("used", True, False)}
    absent = placed(0.0, STALE + 1.0, present=False)
    begins = absent.index(("silent", False, False))
    assert begins * STEP == pytest.approx(STALE, abs=2.0 * STEP)
    assert set(absent[:begins]) == {("used", False, False)}
    assert set(absent[begins:]) == {("silent", False, False)}


@pytest.mark.parametrize(("odd", "pace"), [(0.0, ASTRAY), (1.0, BY_WIND)])
@pytest.mark.parametrize(("share", "taken"), [(0.8, True), (1.5, False)])
def test_a_position_that_returns_is_believed_as_far_as_the_one_carried_on_may_err(
    odd, pace, share, taken
):
    zeros, silence, carried = np.zeros(POSITION_CHECK.size), 20.0, np.zeros(3)
    check = Evaluated(position_checked, POSITION_CHECK, zeros, [1, 3, 1, 3, 1, 1, 1])
    for k in range(round(silence / STEP)):
        check(STEP, carried, float(k == 0), carried, 0.0, 0.0, odd)
    returned = np.array([share * DEVIATIONS * pace * (silence - STALE), 0.0, 0.0])
    code, place, _, moved, _ = check(STEP, returned, 1.0, carried, 0.0, 0.0, odd)
    assert STATES[int(code[0])] == ("used" if taken else "jumped")
    assert bool(moved[0]) == bool((place == returned).all()) == taken
    assert not POSITION_CHECK.parts(check.memory).faded.any()
