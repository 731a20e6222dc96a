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

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.comparison.measures import Measures
from uav_tracking_mpc.studies.comparison.mismatch_targets import (
    ASKED,
    Asked,
    asked_of,
    missed,
    resolved,
)
from uav_tracking_mpc.studies.comparison.mismatches import MISMATCHES, mismatched

GOOD = Measures(
    range_rms_m=0.2,
    range_mean_m=-0.05,
    worst_m=0.5,
    settling_s=10.0,
    altitude_rms_m=0.0,
    airspeed_rms_mps=0.0,
    bank_rate_rms_dps=2.0,
    envelope_violations=0,
    violations={},
    off_plan=0,
)
ABSOLUTE = Asked(0.3, 2.0, range_mean=0.1, optimal=True)
RELATIVE = Asked(0.7, 1.5, relative=True)
OTHERS = {
    "l1": replace(GOOD, range_rms_m=0.5, bank_rate_rms_dps=1.0),
    "npfg": replace(GOOD, range_rms_m=0.3, bank_rate_rms_dps=4.0),
}


def judged(asked, **changes):
    return missed(asked, {"nmpc": replace(GOOD, **changes), **OTHERS})


def test_something_is_asked_under_every_mismatch_of_that_aircraft():
    assert set(ASKED) == set(MISMATCHES)
    assert asked_of(mismatched("small_uav", "lag_2"), "lag_2") == Asked(0.5, 3.0)
    assert asked_of(load_configuration("paper"), "lag_2") is None
    assert asked_of(load_configuration("small_uav"), "ice") is None


def test_the_better_law_is_that_of_the_least_range_rms():
    bounds = resolved(RELATIVE, {"nmpc": GOOD, **OTHERS})
    assert bounds.law == "npfg"
    assert (bounds.range_rms, bounds.bank_rate_rms) == pytest.approx((0.21, 6.0))
    assert resolved(ABSOLUTE, OTHERS) is ABSOLUTE


def test_a_good_flight_misses_nothing():
    assert judged(ABSOLUTE) == judged(RELATIVE) == []


@pytest.mark.parametrize(
    ("asked", "changes", "words"),
    [
        (ABSOLUTE, {"range_rms_m": 0.4}, "range RMS 0.4 m, at most 0.3 m"),
        (ABSOLUTE, {"range_rms_m": math.nan}, "range RMS nan m, at most 0.3 m"),
        (ABSOLUTE, {"range_mean_m": -0.2}, "mean of the range error 0.2 m, at most 0.1 m"),
        (ABSOLUTE, {"bank_rate_rms_dps": 3.0}, "bank rate RMS 3 deg/s, at most 2 deg/s"),
        (ABSOLUTE, {"off_plan": 4}, "4 commands off the optimal plan"),
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
def test_each_miss_is_said(asked, changes, words):
    assert judged(asked, **changes) == [words]


def test_what_is_not_asked_is_not_missed():
    gusty = replace(RELATIVE, limits=False)
    changes = {"envelope_violations": 3, "violations": {"bank": 3}, "off_plan": 9}
    assert judged(gusty, range_mean_m=5.0, **changes) == []


def test_alone_nothing_is_compared_and_without_the_controller_nothing_is_judged():
    assert missed(RELATIVE, {"nmpc": replace(GOOD, range_rms_m=99.0)}) == []
    assert missed(ABSOLUTE, OTHERS) == []
