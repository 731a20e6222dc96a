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

"""Positions arbitrate between a velocity that is measured and one that is expected."""

import numpy as np

from uav_tracking_mpc.estimation.velocity_check import ODD, WINDOW, Velocity, VelocityCheck

STEP = 0.1
EXPECTED = np.array([20.0, 0.0, 0.0])
ODD_ONE = np.add(EXPECTED, (0.0, 2.0 * ODD, 0.0))


def judged(check, flown, measured, duration, deviation=0.0):
    """Verdicts over a time in which one velocity is flown and one measured."""
    steps = range(round(duration / STEP))
    return [check.judge(STEP, k * STEP * flown, measured, EXPECTED, deviation) for k in steps]


def test_what_is_near_is_expected_and_what_is_uncertain_may_be_farther():
    check = VelocityCheck()
    near = np.add(EXPECTED, (0.9 * ODD, 0.0, 0.0))
    assert set(judged(check, near, near, 3.0)) == {Velocity.EXPECTED}
    assert set(judged(check, EXPECTED, ODD_ONE, 3.0, deviation=ODD)) == {Velocity.EXPECTED}


def test_a_velocity_that_is_not_flown_stays_odd():
    assert set(judged(VelocityCheck(), EXPECTED, ODD_ONE, 10.0 * WINDOW)) == {Velocity.ODD}


def test_a_velocity_that_is_flown_is_new_after_the_window():
    verdicts = judged(VelocityCheck(), ODD_ONE, ODD_ONE, 2.0 * WINDOW)
    first = verdicts.index(Velocity.NEW)
    assert set(verdicts[:first]) == {Velocity.ODD}
    assert abs((first + 1) * STEP - WINDOW) < 2.0 * STEP


def test_a_fault_that_turns_into_a_change_is_believed_at_last():
    check = VelocityCheck()
    assert Velocity.NEW not in judged(check, EXPECTED, ODD_ONE, 3.5 * WINDOW)
    assert Velocity.NEW in judged(check, ODD_ONE, ODD_ONE, 2.5 * WINDOW)


def test_an_odd_one_between_good_ones_is_forgotten():
    check = VelocityCheck()
    for _ in range(5):
        assert judged(check, EXPECTED, ODD_ONE, 0.5 * WINDOW)[-1] is Velocity.ODD
        assert judged(check, EXPECTED, EXPECTED, STEP) == [Velocity.EXPECTED]
