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

"""Airspeeds and headings that fail are left out; air that changes is not taken for one."""

import math

import casadi as ca
import numpy as np
import pytest
from evaluated_check import Evaluated

from uav_tracking_mpc.estimation.air_check import (
    AIR_CHECK,
    AIRSPEED,
    COMPASS_CHECK,
    HEADING,
    air_checked,
    compass_checked,
    repeated,
)
from uav_tracking_mpc.estimation.flight_path import NOSE_JUMP
from uav_tracking_mpc.estimation.motion_check import RETURN
from uav_tracking_mpc.estimation.sensor_health import STATES

STEP, AIRSPEED_FLOWN, TURN = 0.05, 22.0, 0.073


class AirCheck(Evaluated):
    """Of airspeed and heading; the time is that of the last call."""

    def __init__(self, settled=0.0, astray=1.0):
        def check(known, dt, heading, reading, present, level, air, deviation, moved, rates):
            air = air[:2], air[2:]
            seen = heading, reading, present, level, air, deviation, settled, moved
            seen = *seen, 1.0, 1.0, rates[0], astray, rates[1], 0.0, 0.0
            after, _, *by_wind = air_checked(known, dt, *seen)
            return after, *by_wind

        super().__init__(check, AIR_CHECK, AIR_CHECK.begin.copy(), [1, 1, 1, 1, 1, 4, 2, 3, 2])
        self.time, self.heading = 0.0, 0.0

    @property
    def reasons(self):
        codes = self.layout.parts(self.memory).reasons
        return ["" if code == 0.0 else STATES[int(code)] for code in codes]

    def judge(self, time, heading, reading, level, air, deviations, explained, acceleration):
        elapsed, self.time = time - self.time, time
        strayed = math.remainder(heading - self.heading - elapsed * TURN, math.tau)
        self.heading = heading
        present = reading is not None
        seen = heading, reading or 0.0, present, level, np.concatenate(air), deviations
        turned, along = self(elapsed, *seen, explained, [strayed, acceleration])
        return float(turned[0]), float(along[0])


def circled(check, reading, begin=0.0, end=100.0, heading_error=0.0, gust=None, **more):
    """Circle in a wind that is known; what was gone by at last, and the reasons on the way."""
    reasons, acceleration = [], more.get("acceleration", 0.0)
    explained = more.get("explained", lambda time: np.zeros(3))
    for k in range(round(begin / STEP), round(end / STEP)):
        time = k * STEP
        heading = math.remainder(TURN * time, 2.0 * math.pi)
        air = AIRSPEED_FLOWN * np.array([math.cos(heading), math.sin(heading)])
        if gust is not None:
            air = air + gust(time)
        by_airspeed = air + more.get("misled", lambda time, heading: 0.0)(time, heading)
        seen = math.remainder(heading + heading_error, 2.0 * math.pi)
        measured = reading(time)
        airs, deviations = [air, by_airspeed], [more.get("deviation", 0.1)] * 2
        known = airs, deviations, explained(time), acceleration
        by_wind = check.judge(time, seen, measured, 1.0, *known)
        out = check.reasons
        gone_by = by_wind[0] if out[HEADING] else seen, by_wind[1] if out[AIRSPEED] else measured
        if not reasons or reasons[-1] != check.reasons:
            reasons.append(list(check.reasons))
    return math.remainder(gone_by[0] - heading, 2.0 * math.pi), gone_by[1], reasons


def right(time):
    return AIRSPEED_FLOWN + 0.01 * math.sin(time)


@pytest.fixture(scope="module")
def settled():
    """A check after 100 s in which nothing fails, flown once for all tests."""
    check = AirCheck()
    assert circled(check, right)[2] == [["", ""]]
    return check


@pytest.fixture
def check(settled):
    check = AirCheck()
    check.memory[:], check.time, check.heading = settled.memory, settled.time, settled.heading
    return check


@pytest.mark.parametrize(("astray", "named"), [(0.0, ""), (0.3, "off")])
def test_what_lasts_from_the_start_is_a_heading_that_strayed_or_else_the_wind(astray, named):
    def misled(time, heading):
        away, turned = ([math.cos(angle), math.sin(angle)] for angle in (heading, heading + 0.8))
        return AIRSPEED_FLOWN * (np.array(turned) - away)

    reasons = circled(AirCheck(astray=astray), right, misled=misled)[2]
    assert reasons[-1] == ["", named]


@pytest.mark.parametrize("wrong", [-22.0, -3.0, 3.0, 10.0])
def test_an_airspeed_that_jumps_is_left_out_until_it_agrees(check, wrong):
    _, airspeed, reasons = circled(check, lambda time: right(time) + wrong, 100.0, 130.0)
    assert airspeed == pytest.approx(AIRSPEED_FLOWN)
    assert reasons[-1] == ["jumped", ""]
    assert circled(check, right, 130.0, 150.0)[2][-1] == ["", ""]
    assert not check.layout.parts(check.memory).doubts.any()  # nothing of it is left


def test_an_airspeed_that_has_jumped_is_no_better_for_a_silence(check):
    def blinking(time):
        return None if 110.0 <= time < 110.2 else right(time) + 6.0

    assert circled(check, blinking, 100.0, 111.0)[2][1:] == [
        ["jumped", ""], ["silent", ""], ["jumped", ""]
    ]  # fmt: skip


def accelerated(begin):
    """What an autopilot that believes a low airspeed adds: 3 m/s^2 along the way for 4 s."""

    def along(time):
        way = np.array([math.cos(TURN * time), math.sin(TURN * time)])
        return 3.0 * min(max(time - begin, 0.0), 4.0) * way

    return along


def test_an_airspeed_that_a_front_has_changed_is_used_again_as_the_aircraft_follows(check):
    """Of an aircraft with mass a tailwind of 9 m/s takes the airspeed first, then it speeds up."""
    lacks = lambda time: min(9.0 * (time - 100.0), 9.0, max(15.0 - 6.0 * (time - 100.0), 0.0))  # noqa: E731

    def blown(time):
        way = np.array([math.cos(TURN * time), math.sin(TURN * time)])
        return (min(9.0 * (time - 100.0), 9.0) - lacks(time)) * way

    seen = lambda time: right(time) - lacks(time)  # noqa: E731
    assert circled(check, seen, 100.0, 102.0, gust=blown)[2][-1] == ["jumped", ""]
    assert circled(check, seen, 102.0, 106.0, gust=blown)[2][-1] == ["", ""]


@pytest.mark.parametrize("begin", [0.3, 1.0, 2.0])
def test_an_airspeed_that_falls_as_soon_as_it_is_compared_does_not_hide_itself(begin):
    check = AirCheck()
    circled(check, right, end=begin, deviation=1.4)
    falling = lambda time: right(time) - min(6.4 * (time - begin), 6.4)  # noqa: E731
    assert circled(check, falling, begin, 15.0, deviation=1.4)[2][-1] == ["jumped", ""]


def test_an_airspeed_is_not_used_again_because_the_autopilot_answers_it(check):
    low = lambda time: right(time) - 5.0  # noqa: E731
    reasons = circled(check, low, 100.0, 120.0, gust=accelerated(101.5))[2]
    assert reasons[-2:] == [["", ""], ["jumped", ""]]


def test_in_gusts_a_wind_that_will_not_be_known_better_judges_once_the_flight_has_lasted():
    for settled, named in ((0.0, ""), (1.0, "jumped")):
        check = AirCheck(settled)
        circled(check, right, deviation=2.0)
        rising = lambda time: right(time) + min(20.0 * (time - 100.0), 10.0)  # noqa: E731
        circled(check, rising, 100.0, 105.0, deviation=2.0)
        assert check.reasons == [named, ""]
        # What leaps by more than a gust can needs no wind.
        circled(check, lambda time: right(time) - 10.0, 105.0, 106.0, deviation=2.0)
        assert check.reasons == ["jumped", ""]


@pytest.mark.parametrize("error", [0.5, -1.5, 3.0])
def test_a_heading_that_jumps_is_left_out(check, error):
    heading, airspeed, reasons = circled(check, right, 100.0, 130.0, heading_error=error)
    assert (heading, airspeed) == pytest.approx((0.0, AIRSPEED_FLOWN), abs=0.02)
    assert reasons[-1] == ["", "jumped"]


@pytest.mark.parametrize("error", [-1.5, 3.0, math.pi, -math.pi])
def test_in_gusts_a_heading_that_is_far_off_stays_left_out(error):
    """One of half a turn is off to the left and to the right in turn."""
    check, rng = AirCheck(), np.random.default_rng(5)
    phases = rng.uniform(0.0, 2.0 * math.pi, (2, 6))
    pace = np.array([0.2, 0.33, 0.51, 0.8, 1.3, 2.1])

    def blowing(time):
        return 0.7 * np.sin(pace * time + phases).sum(axis=1)

    assert circled(check, right, gust=blowing)[2] == [["", ""]]
    reasons = circled(check, right, 100.0, 400.0, heading_error=error, gust=blowing)[2]
    assert reasons in ([["", ""], ["", "jumped"]], [["", "jumped"]])
    assert circled(check, right, 400.0, 430.0, gust=blowing)[2][-1] == ["", ""]


def test_an_airspeed_that_rises_fast_and_misleads_its_wind_is_no_heading(check):
    """A blocked pitot in a climb: the wind that knows the airspeed takes its error, and turns."""

    def misled(time, heading):
        return 1.3 * (time - 100.0) * np.array([-math.sin(heading), math.cos(heading)])

    rising = lambda time: right(time) + max(time - 100.0, 0.0)  # noqa: E731
    circled(check, rising, 100.0, 105.0, misled=misled)
    assert check.reasons == ["jumped", ""]


def test_an_airspeed_that_drifts_is_left_out_before_it_is_off_by_a_quarter(check):
    _, airspeed, _ = circled(check, lambda time: right(time) + 0.1 * (time - 100.0), 100.0, 150.0)
    assert check.reasons[AIRSPEED] == "off"
    assert airspeed == pytest.approx(AIRSPEED_FLOWN)


def test_an_airspeed_that_stays_while_the_aircraft_accelerates_is_stuck(check):
    """It does not come back by agreeing for a while: a clock that stands is right now and then."""
    speeding = lambda time: np.array([2.0, 0.0]) * math.cos(TURN * time)  # noqa: E731
    circled(check, lambda _: 22.0, 100.0, 110.0, gust=speeding, acceleration=0.5)
    assert check.reasons[AIRSPEED] == "stuck"
    circled(check, lambda _: 22.0, 110.0, 150.0)
    assert check.reasons[AIRSPEED] == "stuck"
    circled(check, right, 150.0, 170.0)
    assert check.reasons[AIRSPEED] == ""


def slowing(begin):
    return lambda time: (
        -min(0.5 * max(time - begin, 0.0), 4.0)
        * np.array([math.cos(TURN * time), math.sin(TURN * time)])
    )


def test_an_airspeed_that_stays_while_the_aircraft_slows_down_uncommanded_is_stuck(check):
    """As where the autopilot goes by it, too."""
    assert circled(check, lambda _: 22.0, 100.0, 105.0, gust=slowing(101.0))[2][-1][0] == "stuck"


def test_a_sound_airspeed_in_whole_metres_a_second_is_not_stuck(check):
    def wandering(time):
        ahead = np.array([math.cos(TURN * time), math.sin(TURN * time)])
        return 1.5 * math.sin(0.1 * (time - 100.0)) * ahead

    def coarse(time):
        return round(AIRSPEED_FLOWN + 1.5 * math.sin(0.1 * (time - 100.0)))

    reasons = circled(check, coarse, 100.0, 300.0, gust=wandering)[2]
    assert all(airspeed == "" for airspeed, _ in reasons)


def test_an_airspeed_that_stays_in_steady_flight_is_not_stuck(check):
    assert circled(check, lambda _: 22.0, 100.0, 160.0)[2] == [["", ""]]


def test_without_an_airspeed_the_wind_tells_it(check):
    _, airspeed, reasons = circled(check, lambda _: None, 100.0, 110.0)
    assert airspeed == pytest.approx(AIRSPEED_FLOWN)
    assert reasons[-1] == ["silent", ""]
    assert circled(check, right, 110.0, 112.0)[2][-1] == ["", ""]


@pytest.mark.parametrize("period", [3.0, 10.0, 40.0])
def test_gusts_are_no_fault(period):
    """Of 3 m/s, as strong along as across."""

    def blowing(time):
        angle = 2.0 * math.pi * time / period
        return 3.0 * np.array([math.sin(angle), math.cos(1.1 * angle)])

    check = AirCheck()
    circled(check, right, gust=blowing)
    assert circled(check, right, 100.0, 300.0, gust=blowing)[2] == [["", ""]]


@pytest.mark.parametrize("lasting", [STEP, 2.0, 5.0])
@pytest.mark.parametrize("change", [-9.0, 9.0])
@pytest.mark.parametrize("along", [True, False])
def test_a_front_of_the_wind_is_no_fault(check, along, change, lasting):
    """It changes the ground velocity; what the sensors read changes as the aircraft is flown."""
    begin = 100.0
    direction = TURN * begin + (0.0 if along else 0.5 * math.pi)

    def front(time):
        share = min(max((time - begin) / lasting, 0.0), 1.0)
        return share * change * np.array([math.cos(direction), math.sin(direction)])

    assert circled(check, right, begin, begin + 6.0, gust=front)[2] == [["", ""]]


def test_a_wind_that_turns_is_no_fault(check):
    """By 90 deg in a minute, of which the filter follows a half."""

    def turning(time):
        angle = math.pi / 120.0 * (time - 100.0)
        return 2.5 * np.array([1.0 - math.cos(angle), math.sin(angle)])

    assert circled(check, right, 100.0, 120.0, gust=turning)[2] == [["", ""]]


def test_a_wind_that_changes_across_may_have_changed_along(check):
    """What departs along the heading is an airspeed's fault only where the rest stays as it was."""
    drifting = lambda time: right(time) + 0.1 * (time - 100.0)  # noqa: E731
    moving = lambda time: np.array([0.1 * (time - 100.0), 0.0, 0.0])  # noqa: E731
    assert circled(check, drifting, 100.0, 140.0, explained=moving)[2] == [["", ""]]


def test_a_wind_that_is_soon_found_elsewhere_is_no_airspeed_that_jumps(check):
    """As in turbulence, where the wind that is found without an airspeed is hardly known."""
    rising = lambda time: right(time) + min(2.0 * (time - 100.0), 4.0)  # noqa: E731
    moving = lambda time: np.array([min(2.0 * (time - 100.0), 4.0), 0.0, 0.0])  # noqa: E731
    assert circled(check, rising, 100.0, 105.0, explained=moving)[2] == [["", ""]]


def compass_verdicts(headings, turn, step=STEP, alone=1.0, deviation=0.0, stuck=None, by_nose=0.0):
    """Headings that are gone by, and whether they have jumped."""
    stuck = np.zeros(len(headings)) if stuck is None else stuck
    alone, turn = (np.broadcast_to(each, len(headings)) for each in (alone, turn))
    memory = np.zeros(COMPASS_CHECK.size)
    COMPASS_CHECK.parts(memory).nose[:] = headings[0]
    check = Evaluated(compass_checked, COMPASS_CHECK, memory, [1, 1, 1, 1, 1, 1, 1])
    found = [
        check(step * (k > 0), *seen, by_nose, stands, deviation)
        for k, (*seen, stands) in enumerate(zip(headings, turn, alone, stuck, strict=True))
    ]
    snapped = np.array([float(angle[0]) for _, angle in found])
    return headings - snapped, (np.abs(snapped) > RETURN * NOSE_JUMP).tolist()


def test_a_heading_that_is_stuck_without_an_airspeed_goes_on_as_the_gyros_turn():
    times = STEP * np.arange(200)
    true, stuck = 0.3 * times, times > 5.0
    gone_by, named = compass_verdicts(np.minimum(true, 1.5), 0.3, stuck=stuck)
    assert gone_by == pytest.approx(true, abs=1e-9)
    assert named[110:] == [True] * 90


@pytest.mark.parametrize(
    ("before", "stuck", "after"),
    [
        ("used", 0.0, "used"),
        ("used", 1.0, "stuck"),
        ("stuck", 1.0, "stuck"),
        ("stuck", 0.0, "jumped"),  # it must agree first
        ("off", 1.0, "off"),
    ],
)
def test_what_no_longer_repeats_itself_must_agree_first(before, stuck, after):
    code = float(ca.DM(repeated(ca.DM(STATES.index(before)), ca.DM(stuck))))
    assert STATES[int(code)] == after


def test_a_heading_that_jumps_without_a_turn_is_taken_back():
    times = STEP * np.arange(200)
    true, jumped = 0.3 * times, (times > 3.0) & (times < 7.0)
    # And stays so if others could judge it meanwhile; the nose's compass is in any case.
    for alone, by_nose in ((1.0, 0.0), (times < 5.0, 0.0), (0.0, 1.0)):
        gone_by, named = compass_verdicts(true + 0.5 * jumped, 0.3, alone=alone, by_nose=by_nose)
        assert gone_by == pytest.approx(true)
        assert named == jumped.tolist()
    gone_by, named = compass_verdicts(true + 0.5 * jumped, 0.3, alone=0.0)
    assert gone_by == pytest.approx(true + 0.5 * jumped)  # for others to judge
    assert not any(named)


def test_gyros_that_err_for_a_moment_make_no_compass_leap():
    times = STEP * np.arange(200)
    rates = np.where(np.arange(200) == 80, -5.0, 0.3)
    gone_by, named = compass_verdicts(0.3 * times, rates, alone=0.0, by_nose=1.0)
    assert gone_by == pytest.approx(0.3 * times)
    assert not any(named)


@pytest.mark.parametrize(("step", "noise"), [(0.05, 0.05), (1.0, 0.0)])
def test_a_noisy_heading_and_one_that_is_seldom_measured_jump_nowhere(step, noise):
    times = step * np.arange(400)
    seen = 0.4 * np.sin(0.5 * times) + np.random.default_rng(1).normal(0.0, noise, 400)
    assert not any(compass_verdicts(seen, 0.0, step, deviation=noise)[1])


@pytest.mark.parametrize("bias", [0.0, 0.02])
def test_a_compass_that_drifts_strays_and_one_beside_gyros_with_a_bias_does_not(bias):
    memory, sizes = np.zeros(COMPASS_CHECK.size), [1, 1, 1, 1, 1, 1, 1]
    check, turn, drift = Evaluated(compass_checked, COMPASS_CHECK, memory, sizes), 0.1, 0.0175
    apart = []
    for k in range(2000):
        time = k * STEP
        nose = turn * time + drift * max(time - 85.0, 0.0)
        nose = math.remainder(nose, math.tau)
        angle, _ = check(STEP * (k > 0), nose, turn + bias, 0.0, 0.0, 0.0, 0.0)
        apart.append(angle[0])
    assert sum(apart[:1700]) == pytest.approx(0.0, abs=0.01)
    assert sum(apart[1700:1900]) == pytest.approx(10.0 * drift, rel=0.1)
