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

from uav_tracking_mpc.studies.faults.recovery import FlownTime, Recovery


def test_flown_time_goes_on_where_a_vehicle_begins_anew():
    flown = FlownTime()
    for stamp in (10.0, 10.5, 11.0, 0.0, 0.5, 1.0):
        flown.state(stamp)
    assert flown.seconds == 2.0


def fly(errors, commanded=lambda time: True):
    """Recovery and time flown when it is judged; the fault ends at 5 s."""
    recovery = Recovery(tolerance=10.0, hold=2.0, limit=30.0)
    for time in np.arange(0.0, 60.0, 0.1):
        recovery.state(time, errors(time), 0.0, commanded(time))
        if time >= 5.0 and recovery._end is None:
            recovery.begin(time)
        done = recovery.done(time)
        if done is not None or recovery.late(time):
            return done, time
    raise AssertionError("never judged")


def test_who_never_left_the_orbit_has_recovered_at_once_when_he_held_it():
    done, time = fly(lambda time: 1.0)
    assert done == 0.0
    assert time == pytest.approx(7.0, abs=0.15)


def test_a_recovery_is_the_time_to_come_back_and_stay():
    done, _ = fly(lambda time: 50.0 if time < 17.0 else 1.0)
    assert done == pytest.approx(12.0, abs=0.15)


def test_passing_through_is_no_recovery():
    done, _ = fly(lambda time: 1.0 if 8.0 < time < 9.0 or time > 20.0 else -50.0)
    assert done == pytest.approx(15.0, abs=0.15)


def test_an_orbit_that_nobody_commands_is_not_held():
    done, _ = fly(lambda time: 1.0, commanded=lambda time: time > 11.0)
    assert done == pytest.approx(6.0, abs=0.15)


def test_who_does_not_come_back_is_late():
    done, time = fly(lambda time: 50.0)
    assert done is None
    assert time == pytest.approx(35.0, abs=0.15)
