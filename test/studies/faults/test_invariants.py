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

from uav_tracking_mpc.studies.faults.invariants import Invariants, Limits, Recovery

LIMITS = Limits(
    lower=np.array([-0.8, -0.8, -1.0]),
    upper=np.array([0.8, 0.8, 1.0]),
    state_age=0.5,
    transport=0.2,
    floor=0.0,
    fence=500.0,
)
PLAN = [[0.1, 0.0, 0.5], [0.8, -0.8, 1.0]]
STARTS = [0.0, 1.0]


@pytest.fixture
def invariants():
    judge = Invariants(LIMITS)
    judge.target([0.0, 0.0, 0.0])
    return judge


def names(violations):
    return [violation.invariant for violation in violations]


@pytest.mark.parametrize(
    ("plan", "starts", "found"),
    [
        (PLAN, STARTS, []),
        ([[np.nan, 0.0, 0.0]], [0.0], ["command finite"]),
        ([[0.0, np.inf, 0.0]], [0.0], ["command finite"]),
        ([[0.0, 0.0, 0.0], [0.81, 0.0, 0.0]], STARTS, ["command limits"]),  # in the plan as well
        ([[0.0, 0.0, -1.1]], [0.0], ["command limits"]),
        (PLAN, [1.0, 1.0], ["command order"]),
        ([], [], ["command complete"]),
    ],
)
def test_commands_outside_the_limits_are_found(invariants, plan, starts, found):
    assert names(invariants.command(0.0, 0.0, plan, starts)) == found


@pytest.mark.parametrize(
    ("position", "found"),
    [
        ([100.0, 0.0, 50.0], []),
        ([0.0, 0.0, -0.1], ["altitude floor"]),
        ([400.0, 400.0, 50.0], ["geofence"]),
        ([np.nan, 0.0, 50.0], ["vehicle finite"]),
    ],
)
def test_the_vehicle_is_watched(invariants, position, found):
    assert names(invariants.state(0.0, position)) == found


def fly(judge, stamps, begin=0.0):
    """States delivered as soon as they are sent, five times as fast as real time."""
    for stamp in stamps:
        judge.state(stamp, [100.0, 0.0, 50.0])
        judge.delivered(begin + stamp / 5.0, stamp)


def test_a_command_from_an_old_state_is_found(invariants):
    fly(invariants, np.arange(0.0, 10.0, 0.05))
    newest = 9.95
    now = newest / 5.0
    # What was delivered 0.2 s of wall time ago, 1 s of flight, is known; 0.5 s more are allowed.
    assert invariants.command(now, newest - 1.4, PLAN, STARTS) == []
    assert names(invariants.command(now, newest - 1.6, PLAN, STARTS)) == ["state age"]


def test_a_state_that_was_never_delivered_or_has_a_tampered_stamp_is_not_held_against_it(
    invariants,
):
    fly(invariants, np.arange(0.0, 5.0, 0.05))
    for stamp in np.arange(5.0, 20.0, 0.05):
        invariants.state(stamp, [100.0, 0.0, 50.0])
    invariants.delivered(1.0, 1e9)
    assert invariants.command(4.0, 4.95, PLAN, STARTS) == []


def test_a_vehicle_that_starts_anew_makes_no_command_old(invariants):
    fly(invariants, np.arange(0.0, 50.0, 0.05))
    fly(invariants, np.arange(0.0, 5.0, 0.05), begin=20.0)
    assert invariants.command(30.0, 4.95, PLAN, STARTS) == []
    assert names(invariants.command(30.0, 1.0, PLAN, STARTS)) == ["state age"]


def test_flown_time_goes_on_where_a_vehicle_begins_anew():
    recovery = Recovery(tolerance=10.0)
    for stamp in (10.0, 10.5, 11.0, 0.0, 0.5, 1.0):
        recovery.state(stamp, 0.0, 0.0, True)
    assert recovery.flown == 2.0


def fly_recovery(errors, commanded):
    """Recovery and time flown when it is judged; the fault ends at 5 s."""
    recovery, begun = Recovery(tolerance=10.0), False
    for time in np.arange(0.0, 60.0, 0.1):
        recovery.state(time, errors(time), 0.0, commanded(time))
        if time >= 5.0 and not begun:
            recovery.begin()
            begun = True
        done = recovery.done()
        if done is not None or recovery.late():
            return done, time
    raise AssertionError("never judged")


@pytest.mark.parametrize(
    ("errors", "commanded", "recovered", "judged"),
    [
        # who never left the orbit has recovered at once when he held it
        (lambda time: 1.0, lambda time: True, 0.0, 7.0),
        # the time to come back and stay
        (lambda time: 50.0 if time < 17.0 else 1.0, lambda time: True, 12.0, 19.0),
        # passing through is no recovery
        (lambda time: 1.0 if 8.0 < time < 9.0 or time > 20.0 else -50.0, lambda time: True, 15.0,
         22.0),
        # an orbit that nobody commands is not held
        (lambda time: 1.0, lambda time: time > 11.0, 6.0, 13.0),
        # who does not come back is late
        (lambda time: 50.0, lambda time: True, None, 35.0),
    ],
)  # fmt: skip
def test_a_recovery_is_the_time_until_the_orbit_is_held(errors, commanded, recovered, judged):
    done, time = fly_recovery(errors, commanded)
    assert done == (None if recovered is None else pytest.approx(recovered, abs=0.15))
    assert time == pytest.approx(judged, abs=0.15)
