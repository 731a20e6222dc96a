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

"""What is asked in scenarios, under mismatches and of sensors: met or missed by numbers."""

import math
from dataclasses import replace

import pytest

from uav_tracking_mpc.settings.configuration import load_configuration, scenario_names
from uav_tracking_mpc.simulation.flight_log import SensorNews
from uav_tracking_mpc.studies.comparison.asked import (
    ASKED,
    ASKED_OF_SENSORS,
    ASKED_ON_JSBSIM,
    BETTER,
    TARGETS,
    Asked,
    AskedOfSensors,
    Target,
    asked_of,
)
from uav_tracking_mpc.studies.comparison.measures import Measures, worst
from uav_tracking_mpc.studies.comparison.scenarios import MISMATCHES, SENSOR_FAULTS, mismatched

TARGET = Target(range_rms=0.1, settling=20.0)
GOOD = Measures(
    range_rms_m=0.05, range_mean_m=0.0, worst_m=0.1, settling_s=15.0, altitude_rms_m=0.1,
    airspeed_rms_mps=0.1, bank_rate_rms_dps=1.0, swing_deg=0.5, softened=1.0,
    envelope_violations=0, violations={}, off_plan=0, altitude_min_m=-0.2, altitude_max_m=0.0,
    airspeed_worst_mps=0.2, airspeed_min_mps=20.0, airspeed_max_mps=24.0,
    airspeed_departed_s=(None,), sensors=((),),
)  # fmt: skip
BEYOND = {"envelope_violations": 3, "violations": {"bank": 2, "force": 1}}


def flight(**changes):
    return replace(GOOD, **changes)


def judged(scenario, own, *others):
    configuration = load_configuration("small_uav", scenario=scenario)
    laws = dict(zip(("l1", "vector_field"), others, strict=False))
    return TARGET.missed(configuration, {"nmpc": own, **laws})


def test_what_is_asked_goes_by_aircraft_plant_and_name():
    """Everything that comes along is asked for, of small_uav; by jsbsim less, and other figures."""
    small_uav, paper = load_configuration("small_uav"), load_configuration("paper")
    assert set(TARGETS) == set(scenario_names())
    assert {*ASKED, *ASKED_OF_SENSORS} == set(MISMATCHES)
    assert set(ASKED_OF_SENSORS) == set(SENSOR_FAULTS)
    assert asked_of(small_uav, "wind") == Target(0.03, 20.0)
    assert asked_of(small_uav, "lag_2") == Asked(0.5, 3.0)
    assert asked_of(small_uav, "storm") is None
    assert asked_of(paper, "wind") is asked_of(paper, "lag_2") is None
    on_jsbsim = mismatched("small_uav", "lag_3", ("uav_simulator.plant=jsbsim",))
    assert set(ASKED_ON_JSBSIM) <= set(MISMATCHES)
    assert asked_of(on_jsbsim, "lag_3") == ASKED_ON_JSBSIM["lag_3"]
    assert asked_of(on_jsbsim, "zigzag") is None


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"range_rms_m": 0.2}, "range RMS 0.200 m, at most 0.1 m"),
        ({"range_rms_m": math.nan}, "range RMS nan m"),
        ({"settling_s": 21.0}, "within 10 m after 21.0 s, at most 20 s"),
        ({"settling_s": None}, "within 10 m never"),
        ({"airspeed_rms_mps": 0.4}, "airspeed RMS 0.40 m/s"),
        (BEYOND, "3 samples outside the envelope (bank 2, force 1)"),
    ],
)
def test_each_miss_is_said(changes, words):
    assert judged("wind", flight(), flight(range_rms_m=0.06)) == []
    assert judged("wind", flight(**changes))[0].startswith(words)


@pytest.mark.parametrize(
    ("scenario", "own", "others", "missed"),
    [
        ("gusts", {"airspeed_rms_mps": 0.4}, (), []),
        ("wind", {"bank_rate_rms_dps": 9.0}, (), []),
        (
            "noisy_target",
            {"bank_rate_rms_dps": 9.0},
            (),
            ["bank rate RMS 9.00 deg/s, at most 5 deg/s"],
        ),
        ("still", {}, [{"range_rms_m": 0.01}], []),
        (
            "still",
            {"range_rms_m": 0.09},
            [{"range_rms_m": 0.01}],
            ["range RMS 0.090 m, 0.010 m by the better classical law"],
        ),
        *(
            (
                scenario,
                own,
                [{"range_rms_m": 0.06, "settling_s": 11.5}, {"range_rms_m": 0.07, "settling_s": 9}],
                late,
            )
            for scenario, own, late in (
                ("wind", {}, ["within 10 m after 15.0 s, 11.5 s by the better classical law"]),
                ("wind", {"settling_s": 14.5}, []),
                ("gusts", {}, []),
            )
        ),
    ],
)
def test_what_counts_depends_on_the_scenario_and_on_the_better_law(scenario, own, others, missed):
    assert judged(scenario, flight(**own), *(flight(**other) for other in others)) == missed


@pytest.mark.parametrize("scenario", ["wind", "headwind", "circling_target", "gusts"])
def test_where_air_or_target_moves_it_must_be_better_than_both(scenario):
    better, same = flight(range_rms_m=0.06), flight()
    assert judged(scenario, flight(), better, better) == []
    assert "must be below 0.050 m" in judged(scenario, flight(), better, same)[0]


SOUND = flight(range_rms_m=0.2, range_mean_m=-0.05, bank_rate_rms_dps=2.0)
CROSSWIND = load_configuration("small_uav", scenario="crosswind")
ABSOLUTE = Asked(0.3, 2.0, range_mean=0.1, optimal=True)
RELATIVE = Asked(0.7, 1.5, relative=BETTER)
SWUNG = Asked(0.3, 2.0, swing=3.0, unswung=True)
OTHERS = {
    "l1": replace(SOUND, range_rms_m=0.5, bank_rate_rms_dps=1.0),
    "npfg": replace(SOUND, range_rms_m=0.3, bank_rate_rms_dps=4.0),
}


@pytest.mark.parametrize(
    ("asked", "changes", "words"),
    [
        (ABSOLUTE, {}, None),
        (RELATIVE, {}, None),
        # What is not asked is not missed.
        (replace(RELATIVE, limits=False), {"range_mean_m": 5.0, "off_plan": 9, **BEYOND}, None),
        (ABSOLUTE, {"range_rms_m": 0.4}, "range RMS 0.4 m, at most 0.3 m"),
        (ABSOLUTE, {"range_rms_m": math.nan}, "range RMS nan m, at most 0.3 m"),
        (ABSOLUTE, {"range_mean_m": -0.2}, "mean of the range error 0.2 m, at most 0.1 m"),
        (ABSOLUTE, {"bank_rate_rms_dps": 3.0}, "bank rate RMS 3 deg/s, at most 2 deg/s"),
        (ABSOLUTE, {"off_plan": 4}, "4 commands off the optimal plan"),
        (SWUNG, {"swing_deg": 4.0}, "swing of the bank 4 deg, at most 3 deg"),
        (SWUNG, {"softened": 64.0}, "the loop was softened 64 times"),
        (RELATIVE, BEYOND, "samples outside the envelope: bank 2"),
        (
            RELATIVE,
            {"range_rms_m": 0.22},
            "range RMS 0.22 m, at most 0.21 m, 0.7 times that of npfg",
        ),
        (
            RELATIVE,
            {"bank_rate_rms_dps": 7.0},
            "bank rate RMS 7 deg/s, at most 6 deg/s, 1.5 times that of npfg",
        ),
    ],
)
def test_each_miss_under_a_mismatch_is_said(asked, changes, words):
    found = asked.missed(CROSSWIND, {"nmpc": replace(SOUND, **changes), **OTHERS})
    assert found == ([] if words is None else [words])


@pytest.mark.parametrize(
    ("relative", "law", "range_rms", "bank_rate"),
    [(BETTER, "npfg", 0.21, 6.0), ("l1", "l1", 0.35, 1.5), ("gust_moderate", None, 0.7, 15.0)],
)
def test_shares_are_those_of_a_law_or_of_another_mismatch(relative, law, range_rms, bank_rate):
    """The better law is that of the least range RMS; where it has not flown nothing is compared."""
    asked = replace(RELATIVE, relative=relative)
    told_right = replace(SOUND, range_rms_m=1.0, bank_rate_rms_dps=10.0)
    beside = {"gust_moderate": told_right, "position_spikes": replace(SOUND, range_rms_m=0.0)}
    bounds = asked.resolved({"nmpc": SOUND, **beside, **OTHERS})
    assert bounds.law == (law or relative)
    assert (bounds.range_rms, bounds.bank_rate_rms) == pytest.approx((range_rms, bank_rate))
    assert asked.missed(CROSSWIND, {"nmpc": replace(SOUND, range_rms_m=99.0)}) == []
    assert ABSOLUTE.resolved(OTHERS) is ABSOLUTE


@pytest.mark.parametrize("asked", [TARGET, ABSOLUTE, AskedOfSensors(worst=0.0)])
def test_without_the_controller_nothing_is_judged(asked):
    assert asked.missed(CROSSWIND, {"l1": flight(settling_s=None)}) == []


def test_of_several_flights_each_figure_is_the_worst():
    one = replace(SOUND, range_mean_m=-0.3, violations={"bank": 2}, settling_s=10.0, softened=8.0)
    other = replace(SOUND, range_rms_m=0.4, violations={"force": 1}, settling_s=None)
    both = worst([one, other])
    assert (both.range_rms_m, both.range_mean_m, both.settling_s) == (0.4, -0.3, None)
    assert both.violations == {"bank": 2, "force": 1}
    assert both.softened == 8.0
    assert worst([one]) == one


def lasting(duration):
    return replace(CROSSWIND, mission=replace(CROSSWIND.mission, duration=duration))


def missed(asked, **figures):
    return asked.missed(lasting(300.0), {"nmpc": flight(**figures)})


def told(*news):
    return (tuple(SensorNews(time, "airspeed", state) for time, state in news),)


@pytest.mark.parametrize(
    ("asked", "bad", "words"),
    [
        ({"worst": 0.3}, {"worst_m": 0.4}, "range error up to 0.4 m"),
        ({"airspeed": 0.5}, {"airspeed_worst_mps": 0.6}, "airspeed up to 0.60 m/s off"),
        ({}, {"airspeed_min_mps": 13.9}, "airspeed from 13.9"),
        ({}, {"airspeed_max_mps": 32.1}, "to 32.1 m/s"),
        ({"overshoot": 0.1}, {"altitude_max_m": 0.2}, "altitude overshoots by 0.20 m"),
        ({"overshoot": 0.1}, {"altitude_min_m": -3.2}, "altitude overshoots by 0.20 m"),
        ({"quiet": True}, {"sensors": told((130.0, "off"))}, "was said to be off after 130.0 s"),
    ],
)
def test_what_is_beyond_its_bound_is_missed(asked, bad, words):
    asked = AskedOfSensors(**{"slowest": 14.0, **asked})
    assert not missed(asked)
    assert [line for line in missed(asked, **bad) if words in line]


IN_TIME = AskedOfSensors(named="airspeed", within=2.0, recovers=True)
ONCE_IT_DEPARTS = AskedOfSensors(named="airspeed", departed=5.0)


@pytest.mark.parametrize(
    ("asked", "departed", "news", "words"),
    [
        (IN_TIME, None, (), "the airspeed was never named"),
        (IN_TIME, None, ((100.0, "off"),), "the airspeed was never named"),
        (IN_TIME, None, ((123.0, "off"),), "was named after 123.0 s, must be after 122.0 s"),
        (IN_TIME, None, ((121.0, "off"),), "was not used again"),
        (IN_TIME, None, ((121.0, "off"), (260.0, "used")), "was not used again"),
        (IN_TIME, None, ((121.0, "off"), (215.0, "used")), None),
        (ONCE_IT_DEPARTS, None, (), None),
        (ONCE_IT_DEPARTS, 140.0, (), "the airspeed was never named"),
        (ONCE_IT_DEPARTS, 140.0, ((144.0, "stuck"),), None),
        (ONCE_IT_DEPARTS, 140.0, ((146.0, "stuck"),), "must be after 145.0 s"),
    ],
)
def test_a_sensor_is_to_be_named_in_time_and_used_again(asked, departed, news, words):
    lines = missed(asked, airspeed_departed_s=(departed,), sensors=told(*news))
    assert not lines if words is None else any(words in line for line in lines)


def test_in_a_shorter_mission_what_fails_is_to_be_named_sooner():
    for named, words in ((61.0, []), (59.0, ["the airspeed was never named"])):
        asked = AskedOfSensors(named="airspeed", within=2.0)
        flown = flight(airspeed_departed_s=(None,), sensors=told((named, "off")))
        assert asked.missed(lasting(150.0), {"nmpc": flown}) == words


def test_what_is_asked_of_sensors_is_said_in_words():
    words = {name: asked.words({}) for name, asked in ASKED_OF_SENSORS.items()}
    assert all(words.values())
    assert words["airspeed_plus_3"] == "worst 0.3 m, airspeed 1.5 m/s, airspeed named in 5 s"
    assert words["heading_30"] == "worst 0.3 m, heading named"
