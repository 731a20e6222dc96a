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

"""A limit cycle is noticed with its period and amplitude; swings in gusts are none."""

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from uav_tracking_mpc.control.event import EventLog, Level
from uav_tracking_mpc.control.watches import (
    LONGEST,
    MARGIN,
    AirspeedMargin,
    AirspeedWatch,
    LimitCycleWatch,
    OrbitShortfall,
    OscillationReport,
)
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.response_estimator import ChannelResponse
from uav_tracking_mpc.parameters.specification import changed
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate

TICK = 0.05


def watched(values):
    """What the watch says of each sample."""
    watch, found = LimitCycleWatch(), []
    for tick, value in enumerate(values):
        watch.see(tick * TICK, float(value))
        found.append(watch.swing)
    return found


def times(seconds):
    return np.arange(0.0, seconds, TICK)


@pytest.mark.parametrize("period", [0.5, 1.7, 6.0, 12.0])
@pytest.mark.parametrize("shape", [np.sin, lambda angle: np.sign(np.sin(angle))])
def test_a_regular_swing_is_found_with_period_and_amplitude(period, shape):
    time = times(max(20.0, 9.0 * period))
    *_, swing = watched(0.2 + 0.3 * shape(2.0 * math.pi * time / period))
    assert swing.period == pytest.approx(period, rel=0.1)
    assert 0.2 < swing.amplitude < 0.45


@pytest.mark.parametrize(
    "values",
    [
        0.03 * np.sin(4.0 * times(60.0)),  # small
        0.3 * np.sin(2.0 * math.pi * times(200.0) / (2.0 * LONGEST)),  # an orbit in wind
        0.3 * np.exp(-0.3 * times(60.0)) * np.sin(4.0 * times(60.0)),  # dies away
        np.sign(np.sin(0.5 * times(60.0) ** 1.5)) * (times(60.0) < 5.0),  # a manoeuvre
    ],
)
def test_other_swings_are_none(values):
    assert watched(values)[-1] is None


def test_noise_with_the_correlation_of_gusts_is_hardly_ever_taken_for_one():
    alarms = 0
    for seed in range(10):
        rng, value, values = np.random.default_rng(seed), 0.0, []
        for _ in range(round(60.0 / TICK)):
            value += TICK / 0.7 * -value + 0.15 * math.sqrt(2.0 * TICK / 0.7) * rng.normal()
            values.append(value)
        alarms += any(found is not None for found in watched(values))
    assert alarms <= 1


@pytest.mark.parametrize("period", [1.3, 4.5])
def test_what_gusts_make_of_a_loop_with_a_damping_ratio_of_0_15_is_seldom_taken_for_one(period):
    """Its periods are equal, but what it swings by comes and goes; it ends when the gusts do."""
    begun = []
    for seed in range(10):
        rng, swing, rate, values = np.random.default_rng(seed), 0.0, 0.0, []
        natural = 2.0 * math.pi / period
        for gust in rng.normal(0.0, 0.4, round(60.0 * period / TICK)):
            rate += TICK * natural * (gust - 0.3 * rate - swing)
            swing += TICK * natural * rate
            values.append(swing)
        told = [found is not None for found in watched(values)]
        begun += [after for before, after in pairwise(told) if after and not before]
    assert len(begun) <= 3  # in 600 periods


def test_a_swing_whose_width_has_begun_to_vary_does_not_go_on():
    """Gusts that go on shaking a loop that was softened are no reason to soften it again."""
    watch = LimitCycleWatch()
    for now in times(40.0):
        width = 0.3 if now < 20.0 else 0.3 + 0.12 * math.sin(0.8 * now)
        watch.see(now, width * math.sin(4.0 * now))
        if 15.0 < now < 20.0:
            assert watch.going_on
    assert watch.swing is not None
    assert not watch.going_on


def test_it_ends_when_it_ends_and_says_so_once():
    time = times(40.0)
    values = np.where(time < 20.0, 0.3 * np.sin(4.0 * time), 0.0)
    watch = LimitCycleWatch()
    changes = [now for now, value in zip(time, values, strict=True) if watch.see(now, value)]
    begun, ended = changes
    assert 5.0 < begun < 15.0
    assert 20.0 < ended < 25.0
    assert watch.swing is None


def test_a_gap_or_another_time_begins_anew():
    watch = LimitCycleWatch()
    for now in times(20.0):
        watch.see(now, 0.3 * math.sin(4.0 * now))
    assert watch.swing is not None
    watch.see(5.0, 0.3)
    assert watch.swing is None


AIRSPEED = 22.0
UNKNOWN = [ChannelResponse()] * 3
KNOWN = [ChannelResponse(lag=0.3, dead_time=0.2, trusted=True)] * 3


def told(channels, delays, axis=0, quiet=10.0, target=math.inf):
    """Events of a swing by 20 deg of bank, or as much across the path, in 2 s.

    From a time on the target accelerates as much.
    """
    events = EventLog()
    report = OscillationReport(events)
    rate = GRAVITY / AIRSPEED * math.tan(math.radians(20.0))
    during = ""
    for tick in range(round((20.0 + quiet) / 0.05)):
        time = 0.05 * tick
        inputs = [0.0, 0.0]
        inputs[axis] = rate * math.sin(math.pi * time) if time < 20.0 else 0.0
        forced = AIRSPEED * rate if time >= target else 0.0
        report.see(time, tuple(inputs), AIRSPEED, channels, delays, forced)
        during = report.words(axis) if time < 20.0 else during
    return events.take(), during, report


def test_period_amplitude_and_end_are_told():
    (begin, end), during, report = told(UNKNOWN, [0.5] * 3)
    assert begin.level is Level.WARNING
    assert begin.words.startswith(
        "limit cycle of the turn rate: +-20 deg of bank with a period of 2.0 s"
    )
    assert "+-20 deg of bank" in during
    assert end == (Level.INFO, "the limit cycle of the turn rate has ended")
    assert report.words(0) == report.words(1) == "none"


def test_a_target_that_begins_to_swing_ends_no_limit_cycle():
    (begin,), _, report = told(UNKNOWN, [0.5] * 3, quiet=0.0, target=18.0)
    assert begin.words.startswith("limit cycle of the turn rate")
    assert report.swings == (None, None)
    assert report.going_on[0]


def test_a_swing_that_begins_with_the_targets_is_told_once_it_outlasts_that():
    events = EventLog()
    report = OscillationReport(events)
    for tick in range(1600):
        time = 0.05 * tick
        forced = AIRSPEED * 0.1 if time < 20.0 else 0.0
        swings = [0.1 * math.sin(math.pi * time), 0.0]
        report.see(time, swings, AIRSPEED, UNKNOWN, [0.5] * 3, forced)
    (told,) = events.take()
    assert told.words == f"limit cycle of the turn rate: {report.words(0)}"
    assert "is not what was told" in report.words(0)


@pytest.mark.parametrize(
    ("channels", "delays", "cause"),
    [
        (UNKNOWN, [0.1] * 3, "is not what was told"),
        (KNOWN, [0.1] * 3, "together 0.50 s, not 0.10 s"),
        (KNOWN, [0.5] * 3, "weights of the inputs are too small"),
    ],
)
def test_the_cause_is_what_is_known_of_the_response(channels, delays, cause):
    (begin, *_), during, _ = told(channels, delays, quiet=0.0)
    assert cause in begin.words
    assert cause in during


def test_the_path_is_watched_as_well():
    (begin, *_), _, _ = told(UNKNOWN, [0.1] * 3, axis=1)
    assert begin.words.startswith("limit cycle of the path-angle rate: +-0.36 g")


WANTED = Orbit(300.0, 120.0, 22.0, "clockwise")


def told_orbit_shortfall(orbits):
    """Words about orbits, (range, altitude, airspeed), flown for 5 s each."""
    events = EventLog()
    shortfall = OrbitShortfall(events)
    for k, orbit in enumerate(np.repeat(np.array(orbits), 50, axis=0)):
        shortfall.see(0.1 * k, SimpleNamespace(orbit=orbit), WANTED)
    return [event.words for event in events.take()]


def test_an_orbit_that_stays_is_told_once_and_its_end_too():
    words = told_orbit_shortfall([(310.0, 125.0, 20.0)] * 6 + [(300.2, 120.3, 22.1)] * 3)
    assert words == [
        "limits and drift leave no orbit of 300.0 m at 120.0 m and 22.0 m/s: "
        "flying 310.0 m at 125.0 m and 20.0 m/s",
        "the orbit that was asked for is flown again",
    ]


@pytest.mark.parametrize(
    "orbits",
    [
        [(300.5, 121.0, 22.3)] * 6,
        [(500.0 - 50.0 * k, 120.0, 22.0) for k in range(5)],
        [(310.0, 120.0, 22.0)],
    ],
    ids=["next to it", "on the way", "for a moment"],
)
def test_the_orbit_asked_for_and_the_way_to_it_are_not_worth_a_word(orbits):
    assert told_orbit_shortfall(orbits) == []


def test_a_gale_that_the_bank_cannot_hold_is_told_in_flight(monkeypatch):
    overrides = ["nmpc_controller.range=180", "uav_simulator.wind=[-12, 0, 0]",
                 "mission.duration=60", "target_publisher.motion=line",
                 "target_publisher.speed=5"]  # fmt: skip
    words = []
    monkeypatch.setattr(EventLog, "add", lambda self, level, text: words.append(text))
    simulate(load_configuration("small_uav", overrides))
    assert sum(text.startswith("limits and drift leave no orbit of 180.0 m") for text in words) == 1


ASKED = load_configuration("small_uav").controller  # airspeed of 14 to 32, 22 on the orbit


def margins(*deviations, asked=ASKED):
    """What is flown by at each standard deviation; and the words."""
    events, flown = EventLog(), asked
    margin = AirspeedMargin(asked, events)
    for deviation in deviations:
        flown = margin.flown(asked, deviation) or flown
        yield flown, [event.words for event in events.take()]


def test_an_airspeed_that_stays_beyond_a_limit_is_told_once_and_its_end_too():
    asked = load_configuration("small_uav").controller  # 14 to 32 m/s
    events = EventLog()
    watch = AirspeedWatch(events)
    flown = [13.0] * 80 + [15.0] + [13.0] * 200 + [13.8] * 200 + [14.5] * 20 + [33.0] * 200
    for tick, airspeed in enumerate(flown):
        watch.see(tick * TICK, airspeed, asked)
    assert [event.words for event in events.take()] == [
        "the airspeed is 13.0 m/s, below airspeed_min 14 m/s for 5 s: does the engine run?",
        "the airspeed is inside its limits again",
        "the airspeed is 33.0 m/s, above airspeed_max 32 m/s for 5 s",
    ]


def test_an_engine_that_gives_nothing_is_told_in_flight(monkeypatch):
    overrides = ["uav_simulator.speed_min=5", "uav_simulator.initial_speed=9",
                 "uav_simulator.command_gain=[1, 1, 0.1]",
                 "mission.duration=7"]  # fmt: skip
    words = []
    monkeypatch.setattr(EventLog, "add", lambda self, level, text: words.append(text))
    simulate(load_configuration("small_uav", overrides))
    assert sum("below airspeed_min 14 m/s" in text for text in words) == 1


def test_what_is_not_known_of_the_airspeed_is_kept_from_the_least_one():
    slow = changed(ASKED, {"airspeed": 15.0})
    (few, begins), (same, _), (more, _), (many, _), (known, ends) = margins(
        0.8, 0.9, 2.0, 10.0, 0.0, asked=slow
    )
    assert same is few
    for flown, raised in ((few, MARGIN * 0.8), (more, MARGIN * 2.0), (many, 9.0)):
        assert flown.airspeed == pytest.approx(14.0 + raised)  # at most the middle
        assert flown.airspeed_min == pytest.approx(14.0 + 0.5 * raised)
    assert known is slow
    assert (begins, ends) == (
        ["the airspeed is not known: the orbit is flown at 16.0 m/s"],
        ["the airspeed is known again"],
    )
    ((quick, _),) = margins(2.0)
    assert quick.airspeed == ASKED.airspeed  # that is enough


def test_the_margin_ends_where_the_orbit_would_become_too_sharp():
    sharp = changed(ASKED, {"range": 128.0, "airspeed": 15.0})
    ((flown, _),) = margins(10.0, asked=sharp)
    assert 15.0 < flown.airspeed < 19.0
    assert not flown.envelope.refusal(flown.orbit, np.zeros(3))


@pytest.mark.parametrize(
    ("which", "limit", "asked", "orbits"),
    [(0, 14.0, 22.0, (23.0, 26.6)), (1, 32.0, 24.0, (23.0, 19.4))],
)
def test_an_airspeed_in_doubt_is_kept_as_far_from_the_limit(which, limit, asked, orbits):
    """Above the least one where it may be too high, below the greatest where it may be too low."""
    events, space = EventLog(), abs(asked - limit)
    asked = changed(ASKED, {"airspeed": asked})
    margin = AirspeedMargin(asked, events)

    def flown(doubt):
        return margin.flown(asked, 0.0, (0.0, doubt / MARGIN) if which else (doubt / MARGIN, 0.0))

    assert flown(space) is None  # that is enough
    for doubt, orbit in zip((9.0, 20.0), orbits, strict=True):  # at most 0.7 of the band
        by = flown(doubt)
        assert by.airspeed == pytest.approx(orbit)
        kept = (by.airspeed_min, by.airspeed_max)[which]
        assert kept == pytest.approx(0.5 * (limit + orbit))
        assert (by.airspeed_max, by.airspeed_min)[which] == 46.0 - limit
    assert flown(0.0) is asked
    assert [event.words for event in events.take()] == [
        "the airspeed is in doubt: the orbit is flown at 23.0 m/s",
        "the airspeed is known again",
    ]


def test_an_airspeed_that_is_not_known_is_kept_from_the_greatest_one_too():
    ((flown, _),) = margins(2.0, asked=changed(ASKED, {"airspeed": 30.0}))
    assert flown.airspeed == pytest.approx(32.0 - MARGIN * 2.0)
    assert flown.airspeed_max == pytest.approx(32.0 - 0.5 * MARGIN * 2.0)


def test_other_parameters_do_not_hide_that_the_airspeed_is_known_again():
    events = EventLog()
    margin = AirspeedMargin(ASKED, events)
    for deviation in (2.0, 0.0, 2.0):
        margin.forget(ASKED)
        margin.flown(ASKED, deviation)
    unknown, known = "the airspeed is not known", "the airspeed is known again"
    words = [event.words.split(":")[0] for event in events.take()]
    assert words == [unknown, known, unknown]


@pytest.mark.parametrize("deviation", [math.nan, -1.0])
def test_a_deviation_that_is_none_changes_nothing(deviation):
    ((flown, words),) = margins(deviation)
    assert flown is ASKED
    assert words == []


def test_without_an_airspeed_a_slow_orbit_does_not_begin_below_stall():
    """By its velocity over ground it is too quick; without the margin it sinks to 10 m/s."""
    overrides = ["nmpc_controller.airspeed=15", "mission.duration=12",
                 "uav_simulator.wind=[-6, 0, 0]", "uav_simulator.gust_intensity=15.4",
                 "uav_simulator.airspeed_fault=silent"]  # fmt: skip
    log = simulate(load_configuration("small_uav", overrides))
    assert np.min(log.vehicle[:, 5]) > ASKED.airspeed_min
