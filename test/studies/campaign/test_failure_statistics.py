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
from scipy import stats

from uav_tracking_mpc.studies.campaign.failure_statistics import (
    Failures,
    common_traits,
    quantiles,
    worst_first,
)


@pytest.mark.parametrize(("flights", "failures"), [(2000, 3), (10, 1), (50, 49), (7, 3)])
def test_bounds_are_where_the_binomial_tail_is_5_percent(flights, failures):
    counts = Failures(flights, failures)
    assert stats.binom.cdf(failures, flights, counts.upper) == pytest.approx(0.05, rel=1e-6)
    assert stats.binom.sf(failures - 1, flights, counts.lower) == pytest.approx(0.05, rel=1e-6)
    assert counts.lower < counts.probability < counts.upper


def test_three_of_2000_are_below_04_percent():
    assert Failures(2000, 3).upper < 0.004
    assert Failures(2000, 4).upper > 0.004


def test_bounds_where_none_or_all_fail():
    assert Failures(100, 0).lower == 0.0
    assert Failures(100, 0).upper == pytest.approx(1.0 - 0.05**0.01)
    assert Failures(100, 100).upper == 1.0
    assert Failures(100, 100).lower == pytest.approx(0.05**0.01)


@pytest.mark.parametrize("probability", [0.002, 0.05, 0.5])
def test_bounds_hold_as_often_as_they_claim(probability):
    """Summed over all that can happen: that is exact."""
    happens = stats.binom.pmf(np.arange(201), 200, probability)
    bounds = [Failures(200, count) for count in range(201)]
    upper, lower = (
        np.array([getattr(each, side) for each in bounds]) for side in ("upper", "lower")
    )
    assert happens[upper >= probability].sum() >= 0.95
    assert happens[lower <= probability].sum() >= 0.95


def flights(count=300, seed=0):
    random = np.random.default_rng(seed)
    rows = [
        {
            "flight": number,
            "wind": float(random.uniform(0.0, 10.0)),
            "noise": float(random.uniform(0.0, 1.0)),
            "motion": str(random.choice(["line", "zigzag", "circle"])),
            "constant": 1.0,
        }
        for number in range(count)
    ]
    for row in rows:
        row["failed"] = row["wind"] > 8.0 and row["motion"] == "zigzag"
    return rows


def test_what_failures_have_in_common_is_found():
    rows = flights()
    traits = common_traits(rows, ["wind", "noise", "motion", "constant"], lambda r: r["failed"])
    assert {trait.input for trait in traits} == {"wind", "motion"}
    assert traits[0].input == "wind"
    assert traits[0].rule.startswith("> 8") or traits[0].rule.startswith("> 7.9")
    assert traits[0].share == 1.0
    (motion,) = [trait for trait in traits if trait.input == "motion"]
    assert (motion.rule, motion.share) == ("= zigzag", 1.0)
    assert all(trait.p_value < 0.05 for trait in traits)


def test_small_values_are_told_too():
    rows = flights()
    (trait,) = common_traits(rows, ["wind"], lambda row: row["wind"] < 2.0)
    assert trait.rule.startswith("<= 1.9")
    assert (trait.share, trait.others) == (1.0, 0.0)


def test_chance_is_not_told():
    rows = flights()
    for row in rows:
        row["failed"] = row["flight"] % 10 == 0
    assert common_traits(rows, ["wind", "noise", "motion"], lambda row: row["failed"]) == []


def test_two_failures_have_nothing_to_tell():
    rows = flights()
    assert common_traits(rows, ["wind"], lambda row: row["flight"] < 2) == []


def test_quantiles_are_values_that_were_flown_and_a_missing_one_is_the_worst():
    rows = [{"x": float(value)} for value in range(1, 101)]
    assert quantiles(rows, "x") == [50.0, 90.0, 99.0, 100.0]
    assert quantiles([*rows[:99], {"x": None}], "x") == [50.0, 90.0, 99.0, None]


def test_failures_come_before_large_errors():
    rows = [
        {"flight": 0, "failed": False, "worst_settled_m": 25.0},
        {"flight": 1, "failed": True, "worst_settled_m": 3.0},
        {"flight": 2, "failed": False, "worst_settled_m": 28.0},
        {"flight": 3, "failed": True, "worst_settled_m": None},
    ]
    assert [row["flight"] for row in worst_first(rows)] == [3, 1, 2, 0]
