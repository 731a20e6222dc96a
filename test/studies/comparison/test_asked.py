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


import math
from dataclasses import replace

import pytest

from uav_tracking_mpc.settings.configuration import load_configuration, scenario_names
from uav_tracking_mpc.studies.comparison.asked import (
    ASKED,
    ASKED_ON_JSBSIM,
    BETTER,
    TARGETS,
    Asked,
    Target,
)
from uav_tracking_mpc.studies.comparison.measures import Measures, worst
from uav_tracking_mpc.studies.comparison.scenarios import MISMATCHES, mismatched
from uav_tracking_mpc.studies.comparison.sensor_cases import ASKED_OF_SENSORS, asked_of

TARGET = Target(range_rms=0.1, settling=20.0)
GOOD = {
    "range_rms_m": 0.05,
    "range_mean_m": 0.0,
    "worst_m": 0.1,
    "settling_s": 15.0,
    "altitude_rms_m": 0.1,
    "airspeed_rms_mps": 0.1,
    "bank_rate_rms_dps": 1.0,
    "swing_deg": 0.5,
    "softened": 1.0,
    "envelope_violations": 0,
    "violations": {},
    "off_plan": 0,
}


def flight(**changes):
    return Measures(**{**GOOD, **changes})


def judged(scenario, own, *others):
    configuration = load_configuration("small_uav", scenario=scenario)
    laws = dict(zip(("l1", "vector_field"), others, strict=False))
    return TARGET.missed(configuration, {"nmpc": own, **laws})


def test_every_scenario_that_comes_along_has_a_target():
    assert set(TARGETS) == set(scenario_names())
    small_uav = load_configuration("small_uav", scenario="wind")
    assert asked_of(small_uav, "wind") == Target(0.03, 20.0)
    assert asked_of(small_uav, "storm") is None
    assert asked_of(load_configuration("paper", scenario="wind"), "wind") is None


def test_a_good_flight_misses_nothing():
    assert judged("wind", flight(), flight(range_rms_m=0.06)) == []


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"range_rms_m": 0.2}, "range RMS 0.200 m, at most 0.1 m"),
        ({"range_rms_m": float("nan")}, "range RMS nan m"),
        ({"settling_s": 21.0}, "within 10 m after 21.0 s, at most 20 s"),
        ({"settling_s": None}, "within 10 m never"),
        ({"airspeed_rms_mps": 0.4}, "airspeed RMS 0.40 m/s"),
        (
            {"envelope_violations": 3, "violations": {"bank": 2, "force": 1}},
            "3 samples outside the envelope (bank 2, force 1)",
        ),
    ],
)
def test_each_miss_is_said(changes, words):
    assert judged("wind", flight(**changes))[0].startswith(words)


def test_what_counts_depends_on_the_scenario():
    assert judged("gusts", flight(airspeed_rms_mps=0.4)) == []
    assert judged("wind", flight(bank_rate_rms_dps=9.0)) == []
    assert judged("noisy_target", flight(bank_rate_rms_dps=9.0)) == [
        "bank rate RMS 9.00 deg/s, at most 5 deg/s"
    ]


@pytest.mark.parametrize("scenario", ["wind", "headwind", "circling_target", "gusts"])
def test_where_air_or_target_moves_it_must_be_better_than_both(scenario):
    better, same = flight(range_rms_m=0.06), flight()
    assert judged(scenario, flight(), better, better) == []
    assert "must be below 0.050 m" in judged(scenario, flight(), better, same)[0]


def test_elsewhere_it_may_be_worse_by_a_little():
    assert judged("still", flight(), flight(range_rms_m=0.01)) == []
    far = judged("still", flight(range_rms_m=0.09), flight(range_rms_m=0.01))
    assert far == ["range RMS 0.090 m, 0.010 m by the better classical law"]


def test_it_settles_no_later_than_the_better_law_by_more_than_3_s():
    others = (flight(range_rms_m=0.06, settling_s=11.5), flight(range_rms_m=0.07, settling_s=9.0))
    late = ["within 10 m after 15.0 s, 11.5 s by the better classical law"]
    assert judged("wind", flight(), *others) == late
    assert judged("wind", flight(settling_s=14.5), *others) == []
    assert judged("gusts", flight(), *others) == []


def test_without_the_controller_nothing_is_judged():
    configuration = load_configuration("small_uav", scenario="wind")
    assert TARGET.missed(configuration, {"l1": flight(settling_s=None)}) == []


SOUND = flight(range_rms_m=0.2, range_mean_m=-0.05, bank_rate_rms_dps=2.0)
CROSSWIND = load_configuration("small_uav", scenario="crosswind")
ABSOLUTE = Asked(0.3, 2.0, range_mean=0.1, optimal=True)
RELATIVE = Asked(0.7, 1.5, relative=BETTER)
SWUNG = Asked(0.3, 2.0, swing=3.0, unswung=True)
OTHERS = {
    "l1": replace(SOUND, range_rms_m=0.5, bank_rate_rms_dps=1.0),
    "npfg": replace(SOUND, range_rms_m=0.3, bank_rate_rms_dps=4.0),
}


def told_wrong(asked, **changes):
    return asked.missed(CROSSWIND, {"nmpc": replace(SOUND, **changes), **OTHERS})


def test_something_is_asked_under_every_mismatch_of_that_aircraft():
    assert {*ASKED, *ASKED_OF_SENSORS} == set(MISMATCHES)
    assert asked_of(mismatched("small_uav", "lag_2"), "lag_2") == Asked(0.5, 3.0)
    assert asked_of(load_configuration("paper"), "lag_2") is None
    assert asked_of(load_configuration("small_uav"), "ice") is None


def test_the_better_law_is_that_of_the_least_range_rms():
    bounds = RELATIVE.resolved({"nmpc": SOUND, **OTHERS})
    assert bounds.law == "npfg"
    assert (bounds.range_rms, bounds.bank_rate_rms) == pytest.approx((0.21, 6.0))
    assert ABSOLUTE.resolved(OTHERS) is ABSOLUTE


def test_a_sound_flight_misses_nothing():
    assert told_wrong(ABSOLUTE) == told_wrong(RELATIVE) == []


@pytest.mark.parametrize(
    ("asked", "changes", "words"),
    [
        (ABSOLUTE, {"range_rms_m": 0.4}, "range RMS 0.4 m, at most 0.3 m"),
        (ABSOLUTE, {"range_rms_m": math.nan}, "range RMS nan m, at most 0.3 m"),
        (ABSOLUTE, {"range_mean_m": -0.2}, "mean of the range error 0.2 m, at most 0.1 m"),
        (ABSOLUTE, {"bank_rate_rms_dps": 3.0}, "bank rate RMS 3 deg/s, at most 2 deg/s"),
        (ABSOLUTE, {"off_plan": 4}, "4 commands off the optimal plan"),
        (SWUNG, {"swing_deg": 4.0}, "swing of the bank 4 deg, at most 3 deg"),
        (SWUNG, {"softened": 64.0}, "the loop was softened 64 times"),
        (
            RELATIVE,
            {"envelope_violations": 3, "violations": {"bank": 2, "force": 1}},
            "samples outside the envelope: bank 2",
        ),
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
    assert told_wrong(asked, **changes) == [words]


def test_what_is_not_asked_is_not_missed():
    gusty = replace(RELATIVE, limits=False)
    changes = {"envelope_violations": 3, "violations": {"bank": 3}, "off_plan": 9}
    assert told_wrong(gusty, range_mean_m=5.0, **changes) == []


def test_alone_nothing_is_compared_and_without_the_controller_nothing_is_judged():
    assert RELATIVE.missed(CROSSWIND, {"nmpc": replace(SOUND, range_rms_m=99.0)}) == []
    assert ABSOLUTE.missed(CROSSWIND, OTHERS) == []


def test_shares_may_be_those_of_a_law_or_of_another_mismatch():
    of_l1 = replace(RELATIVE, relative="l1").resolved({"nmpc": SOUND, **OTHERS})
    assert (of_l1.law, of_l1.range_rms, of_l1.bank_rate_rms) == pytest.approx(("l1", 0.35, 1.5))
    of_gusts = replace(RELATIVE, relative="gust_moderate")
    told_right = replace(SOUND, range_rms_m=1.0, bank_rate_rms_dps=10.0)
    bounds = of_gusts.resolved({"nmpc": SOUND, "gust_moderate": told_right, **OTHERS})
    assert (bounds.range_rms, bounds.bank_rate_rms) == pytest.approx((0.7, 15.0))
    assert of_gusts.missed(CROSSWIND, {"nmpc": replace(SOUND, range_rms_m=99.0), **OTHERS}) == []


def test_with_six_degrees_of_freedom_other_figures_are_asked():
    told = ("uav_simulator.plant=jsbsim", "mission.plant=jsbsim")
    assert set(ASKED_ON_JSBSIM) <= set(MISMATCHES)
    assert asked_of(mismatched("small_uav", "lag_3", told), "lag_3") == ASKED_ON_JSBSIM["lag_3"]
    assert asked_of(mismatched("small_uav", "zigzag", told), "zigzag") is None


def test_of_several_flights_each_figure_is_the_worst():
    one = replace(SOUND, range_mean_m=-0.3, violations={"bank": 2}, settling_s=10.0, softened=8.0)
    other = replace(SOUND, range_rms_m=0.4, violations={"force": 1}, settling_s=None)
    both = worst([one, other])
    assert (both.range_rms_m, both.range_mean_m, both.settling_s) == (0.4, -0.3, None)
    assert both.violations == {"bank": 2, "force": 1}
    assert both.softened == 8.0
    assert worst([one]) is one
