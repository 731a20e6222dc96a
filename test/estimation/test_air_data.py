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

import dataclasses
import math
from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.estimation.air_data import STUCK_CLIMB, AirData
from uav_tracking_mpc.estimation.air_estimate import FOUND
from uav_tracking_mpc.estimation.measurement import Axis, Measurement
from uav_tracking_mpc.estimation.motion_check import STALE
from uav_tracking_mpc.estimation.sensor_health import CODE, OFF, STUCK


def data(**known):
    """Beside an estimate that has found this."""
    found = FOUND.parts(FOUND.begin.copy())
    for name, value in known.items():
        getattr(found, name)[:] = value
    return AirData(0.5, found)


def measurement(**more):
    return Measurement(10.0, np.zeros(3), np.array([3.0, 4.0, 0.0]), 2.0, 0.1, **more)


def test_its_own_airspeed_counts_before_the_one_that_came_by_itself():
    air = data()
    air.see(10.0, 20.0)
    *_, heading, path_angle, airspeed = air.see_state(measurement(airspeed=21.0))[1]
    assert (heading, path_angle, airspeed) == (2.0, 0.1, 21.0)
    assert air.see_state(measurement())[1][-1] == 20.0


@pytest.mark.parametrize("climb", [0.0, 2.5, -2.5])
def test_where_height_and_climb_are_stuck_together_the_pitch_tells(climb):
    """An aircraft with an angle of attack of 0.05 rad, which goes over to a climb after 10 s."""
    air, named, rng = data(), [], np.random.default_rng(1)
    for time in np.arange(0.0, 30.0, 0.05):
        climbs = climb if time > 10.0 else 0.0
        told = [20.0, 0.0, 0.0 if time > 8.0 else rng.normal(0.0, 0.1)]
        pitch = 0.05 + climbs / 20.0 + rng.normal(0.0, 0.005)
        seen = Measurement(time, [20.0 * time, 0.0, 100.0], told, 0.0, pitch, bank=1e-3)
        air.see_state(dataclasses.replace(seen, airspeed=20.0))
        if air.climb_state is STUCK:
            named.append(time)
    assert bool(named) is (climb != 0.0)
    assert not named or 10.0 < named[0] < 13.0


@pytest.mark.parametrize("stamp", [9.4, 10.6])
def test_an_airspeed_of_another_time_does_not_count(stamp):
    air = data()
    air.see(stamp, 20.0)
    *_, heading, path_angle, airspeed = air.see_state(measurement())[1]
    assert (heading, path_angle, airspeed) == (np.arctan2(4.0, 3.0), 0.0, 5.0)
    assert air.missing


def test_at_rest_the_body_tells_where_it_would_go():
    standing = Measurement(10.0, np.zeros(3), np.zeros(3), 2.0, 0.1)
    *_, heading, path_angle, airspeed = data().see_state(standing)[1]
    assert (heading, path_angle, airspeed) == (2.0, 0.1, 0.0)


@pytest.mark.parametrize(("stamp", "airspeed"), [(0.0, -1.0), (0.0, np.nan), (np.inf, 20.0)])
def test_what_is_no_airspeed_is_refused(stamp, airspeed):
    air = data()
    with pytest.raises(ValueError, match="airspeed is .* must be finite and at least 0"):
        air.see(stamp, airspeed)


@pytest.mark.parametrize(
    ("turn", "every", "stuck"),
    [
        (0.07, None, True),
        (0.3, None, True),
        (0.0, None, False),  # straight on a heading stays
        (0.6, 0.2, False),  # read five times a second
    ],
)
def test_a_reading_that_stays_while_the_gyros_turn_is_stuck_until_it_changes(turn, every, stuck):
    air, found = data(), []
    for time in np.arange(0.0, 12.0, 0.02):
        read = time if every is None else every * np.floor(time / every)
        read = 4.0 if every is None and 4.0 < time < 8.0 else read
        velocity = np.array([20.0 * np.cos(turn * time), 20.0 * np.sin(turn * time), 0.0])
        air.see_state(Measurement(time, np.zeros(3), velocity, turn * read, 0.0, turn))
        found.append(air.stuck)
    headings, velocities = np.array(found).T
    assert not velocities.any()
    assert not headings[:235].any()
    assert headings[280:399].all() == stuck == headings.any()
    assert not headings[402:].any()


@pytest.mark.parametrize(("climb", "told"), [(0.5, 0.0), (-2.0, 1.0), (1.0, 1.0)])
def test_a_vertical_velocity_that_does_not_change_as_the_aircraft_climbs_is_stuck(climb, told):
    air = data()
    for time in np.arange(0.0, 10.0, 0.05):
        position, velocity = np.array([20.0 * time, 0.0, climb * time]), np.array([20.0, 0.0, told])
        air.see_state(Measurement(time, position, velocity, 0.0, 0.0))
        off = abs(climb - told) * time
        assert abs(off - STUCK_CLIMB) < 0.2 or air.stuck == (False, off > STUCK_CLIMB)


@pytest.mark.parametrize("resolution", [1e-9, 0.5])  # m/s, of the climb: it comes again then
@pytest.mark.parametrize(
    ("period", "unplaced", "found"),
    [(1.0, False, math.inf), (1.0, True, math.inf), (9.0, False, STALE)],
)
def test_a_receiver_that_is_read_seldom_is_not_stuck_and_one_that_stands_is(
    period, unplaced, found, resolution
):
    """It turns and climbs; between two fixes the position stays, or is unknown."""
    air, fixed, first = data(), -math.inf, math.inf
    for time in np.arange(0.0, 6.0, 0.05):
        here = time - fixed >= period - 1e-9
        if here:
            fixed, turned = time, 0.3 * time
            east, north, up = math.cos(turned), math.sin(turned), 4.0 + 0.1 * math.sin(turned)
            position = np.array([20.0 / 0.3 * north, -20.0 / 0.3 * east, 4.0 * time])
            up = resolution * round(up / resolution)
            velocity = np.array([20.0 * east, 20.0 * north, up])
        place = position if here or not unplaced else [math.nan] * 3
        air.see_state(Measurement(time, place, velocity, 0.3 * time, 0.2, 0.3, airspeed=20.0))
        first = min(first, time) if air.stuck[1] else first
    assert first == pytest.approx(found, abs=0.1)


@pytest.mark.parametrize(
    ("changes", "stuck"),
    [({}, True), ({"bank": None}, False), ({"axis": Axis.AIR_VELOCITY}, False)],
)
def test_a_bank_that_stays_while_the_nose_turns_quicker_and_slower_is_stuck(changes, stuck):
    air, nose = data(), 0.0
    for time in np.arange(0.0, 8.0, 0.05):
        rate = 0.1 + 0.15 * math.sin(time)
        nose += 0.05 * rate
        velocity = 20.0 * np.array([math.cos(nose), math.sin(nose), 0.0])
        seen = Measurement(time, np.zeros(3), velocity, nose, 0.0, rate, 0.0, 20.0, bank=-0.2)
        path, _ = air.see_state(replace(seen, **changes))
    words = [said for said, holds in air.concerns().items() if holds]
    assert ("the bank is stuck: the attitude is taken for the direction flown" in words) == stuck
    assert path.turn_rate == rate  # of the nose, or as it is told


def test_a_bank_that_is_left_out_shifts_no_turn():
    """It sticks in a turn, which then ends: that looks like a slip until the turn begins again."""
    air, nose, surplus = data(), 0.0, []
    for time in np.arange(0.0, 30.0, 0.05):
        rate = 0.07 if time < 2.0 else 0.0 if time < 25.0 else 0.2
        nose += 0.05 * rate
        velocity = 20.0 * np.array([math.cos(nose), math.sin(nose), 0.0])
        seen = Measurement(time, 10.0 * velocity, velocity, nose, 0.0, rate, 0.0, 20.0, bank=-0.14)
        air.see_state(seen)
        surplus.append(air.surplus)
    assert surplus[480] < -0.04
    assert surplus[-1] == 0.0


@pytest.mark.parametrize(
    ("airspeed", "ground", "impossible"),
    [
        (27.0, 5.0, False),
        (29.0, 5.0, True),
        (9.0, 20.0, True),
        (9.0, 8.0, False),
        (11.0, 20.0, False),
    ],
)
def test_an_airspeed_at_which_nobody_flies_is_left_out(airspeed, ground, impossible):
    """From 14 to 22 m/s, a quarter beyond; on the ground a low one is right."""
    air = data()
    air.limits = 14.0, 22.0
    seen = Measurement(0.0, np.zeros(3), np.array([ground, 0.0, 0.0]), 0.0, 0.0, airspeed=airspeed)
    air.see_state(seen)
    assert (air.impossible, air.missing) == (impossible, impossible)


@pytest.mark.parametrize(("airspeed", "impossible"), [(9.0, False), (4.0, True), (29.0, True)])
def test_an_airspeed_at_which_the_aircraft_flies_all_the_same_is_not_blamed(airspeed, impossible):
    """From 14 to 22 m/s; with a wind of 5 m/s, 14 m/s over ground tell 9 m/s."""
    air = data(without=[5.0, 0.0, 0.0], known=1.0)
    air.limits = 14.0, 22.0
    seen = Measurement(0.0, np.zeros(3), np.array([14.0, 0, 0]), 0.0, 0.0, airspeed=airspeed)
    air.see_state(seen)
    assert air.impossible == impossible


def test_before_anything_is_estimated_there_is_nothing_to_agree_with():
    air = data()
    air.limits = 14.0, 22.0
    for airspeed, impossible in ((31.0, True), (20.0, False)):
        air.see_state(replace(measurement(), airspeed=airspeed))
        assert air.impossible == impossible


def test_an_airspeed_that_was_impossible_must_agree_before_it_is_used_again():
    air = data(vehicle=[0.0, 0.0, 0.0, 0.0, 0.0, 16.0])
    air.limits = 14.0, 22.0
    for airspeed, impossible in ((31.0, True), (24.0, True), (17.0, False), (24.0, False)):
        air.see_state(replace(measurement(), airspeed=airspeed))
        assert air.impossible == impossible


@pytest.mark.parametrize(
    ("heading", "course", "said"),
    [(0.0, math.pi / 2, True), (math.pi, -math.pi / 2, True), (0.0, 0.5, False), (0.8, 0.8, False)],
)
def test_a_heading_that_counts_from_north_is_told(heading, course, said):
    """Its mirror image is where the aircraft goes; a sound one differs by the drift alone."""
    air, said_so_far = data(), set()
    velocity = 20.0 * np.array([math.cos(course), math.sin(course), 0.0])
    for tick in range(200):
        time = 0.05 * tick
        air.see_state(Measurement(time, time * velocity, velocity, heading, 0.0, airspeed=20.0))
        said_so_far |= {words for words, holds in air.concerns().items() if holds}
    told = "the heading looks as if it counted from North to East: it must count from East to North"
    assert said_so_far == ({f"{told} (ENU)"} if said else set())


@pytest.mark.parametrize(("unit", "failed"), [(1.0, False), (math.degrees(1.0), True)])
def test_a_turn_rate_in_another_unit_is_left_out(unit, failed):
    air, turn, seen = data(), 0.13, []
    for time in np.arange(0.0, 3.0, 0.05):
        velocity = 16.0 * np.array([math.cos(turn * time), math.sin(turn * time), 0.0])
        told = Measurement(time, time * velocity, velocity, turn * time, 0.0, unit * turn)
        seen.append(air.see_state(told)[0].turn_rate)
    assert air.turn_failed == failed
    assert seen[-1] == (0.0 if failed else turn)
    assert any("rad/s" in words for words, holds in air.concerns().items() if holds) == failed


def test_reset_forgets():
    air = data()
    air.see(10.0, 20.0)
    air.reset()
    assert air.see_state(measurement())[1][-1] == 5.0


def test_after_a_gap_the_airspeed_from_before_counts_until_its_own_may_have_come():
    air = data()
    air.see(10.0, 20.0)
    air.see_state(measurement())
    assert air.see_state(replace(measurement(), stamp=12.0))[1][-1] == 20.0
    assert air.see_state(replace(measurement(), stamp=12.0))[1][-1] == 20.0  # asked once more
    assert air.see_state(replace(measurement(), stamp=12.05))[1][-1] == 5.0
    assert air.missing


def test_an_airspeed_that_the_wind_contradicts_does_not_turn_the_path_of_a_body():
    """At 5 m/s a bank of 0.3 rad would turn four times as fast as at 22 m/s."""
    body = Measurement(10.0, np.zeros(3), np.array([22.0, 0.0, 0.0]), 0.0, 0.05, bank=-0.3)
    turns = []
    for known, failed, airspeed in ((0, 0, 22.0), (1, 1, 5.0), (1, 0, 5.0), (0, 0, 5.0)):
        air = data(known=known, states=[failed * CODE[OFF], 0.0, 0.0, 0.0])
        path, state = air.see_state(replace(body, airspeed=airspeed))
        assert state[-1] == airspeed  # for others to judge
        turns.append(path.turn_rate)
    right, told, near, wrong = turns
    assert told == pytest.approx(right, rel=1e-9)
    assert near == pytest.approx(right, rel=0.35)
    assert wrong == pytest.approx(22.0 / 5.0 * right, rel=0.01)


def test_without_an_airspeed_the_path_of_a_body_goes_by_what_is_known_of_the_wind():
    """Downwind the ground goes by faster than the air, and the climb is steeper than it seems."""
    body = Measurement(10.0, np.zeros(3), np.array([30.0, 0.0, 4.0]), 0.0, 0.3, bank=0.0)
    air = data(without=[8.0, 0.0, 0.0])
    path, _ = air.see_state(body)
    assert math.sin(path.path_angle) == pytest.approx(4.0 / math.hypot(22.0, 4.0))


@pytest.mark.parametrize(
    ("airspeed", "failed", "followed"),
    [(22.0, False, False), (22.0, True, True), (None, False, True)],
)
def test_an_autopilot_with_a_wrong_airspeed_dives_and_is_followed_at_once(
    airspeed, failed, followed
):
    air, step = data(states=[failed * CODE[OFF], 0.0, 0.0, 0.0]), 0.02
    air.holds_altitude = True
    for k in range(50):
        time = step * k
        climb, height = -6.0 * time, -3.0 * time**2
        velocity, pitch = np.array([22.0, 0.0, climb]), math.asin(climb / 22.0)
        place = np.array([22.0 * time, 0.0, height])
        body = Measurement(time, place, velocity, 0.0, pitch, airspeed=airspeed, bank=0.0)
        path, _ = air.see_state(body)
    assert path.ground_velocity[2] == pytest.approx(climb if followed else 0.4 * climb, abs=0.1)
