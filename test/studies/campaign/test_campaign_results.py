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


import json
from dataclasses import replace

import numpy as np
import pytest
from campaign_files import short_campaign
from scipy import stats

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.campaign.campaign_results import (
    as_json,
    bounds,
    campaign_study,
    common_traits,
    quantiles,
    worst_first,
)
from uav_tracking_mpc.studies.campaign.campaign_run import run_campaign
from uav_tracking_mpc.studies.executors import LocalExecutor


@pytest.mark.parametrize(("flights", "failures"), [(2000, 3), (10, 1), (50, 49), (7, 3)])
def test_bounds_are_where_the_binomial_tail_is_5_percent(flights, failures):
    counts = bounds(flights, failures)
    assert stats.binom.cdf(failures, flights, counts["upper"]) == pytest.approx(0.05, rel=1e-6)
    assert stats.binom.sf(failures - 1, flights, counts["lower"]) == pytest.approx(0.05, rel=1e-6)
    assert counts["lower"] < counts["probability"] < counts["upper"]


def test_three_of_2000_are_below_04_percent():
    assert bounds(2000, 3)["upper"] < 0.004
    assert bounds(2000, 4)["upper"] > 0.004


def test_bounds_where_none_or_all_fail():
    assert bounds(100, 0)["lower"] == 0.0
    assert bounds(100, 0)["upper"] == pytest.approx(1.0 - 0.05**0.01)
    assert bounds(100, 100)["upper"] == 1.0
    assert bounds(100, 100)["lower"] == pytest.approx(0.05**0.01)


@pytest.mark.parametrize("probability", [0.002, 0.05, 0.5])
def test_bounds_hold_as_often_as_they_claim(probability):
    """Summed over all that can happen: that is exact."""
    happens = stats.binom.pmf(np.arange(201), 200, probability)
    every = [bounds(200, count) for count in range(201)]
    upper, lower = (np.array([each[side] for each in every]) for side in ("upper", "lower"))
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
    assert {trait["input"] for trait in traits} == {"wind", "motion"}
    assert traits[0]["input"] == "wind"
    assert traits[0]["rule"].startswith("> 8") or traits[0]["rule"].startswith("> 7.9")
    assert traits[0]["share"] == 1.0
    (motion,) = [trait for trait in traits if trait["input"] == "motion"]
    assert (motion["rule"], motion["share"]) == ("= zigzag", 1.0)
    assert all(trait["p_value"] < 0.05 for trait in traits)


def test_small_values_are_told_too():
    rows = flights()
    (trait,) = common_traits(rows, ["wind"], lambda row: row["wind"] < 2.0)
    assert trait["rule"].startswith("<= 1.9")
    assert (trait["share"], trait["others"]) == (1.0, 0.0)


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


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("campaign")
    campaign = short_campaign(folder, title="Short <flights>", laws=["l1", "vector_field"])
    return run_campaign(campaign, LocalExecutor(1), folder / "out", show=False)


@pytest.fixture(scope="module")
def failing(results):
    """As if strong winds were too much for l1, and one flight had raised an error."""
    rows = [
        {**row, "failed": True, "reasons": "orbit_lost", "wind.speed": 20.0}
        if row["law"] == "l1" and row["flight"] < 3
        else {**row, "failed": False, "reasons": ""}
        for row in results.rows
    ]
    figures = {key: None for key in rows[0] if key.endswith(("_m", "_s", "_mps", "_dps"))}
    rows[0] = {**rows[0], **figures, "reasons": "raised", "error": "SimulationError: lost"}
    return replace(results, rows=rows)


def test_json_holds_what_counts_and_no_nan(failing):
    content = as_json(failing)
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert list(content["laws"]) == ["l1", "vector_field"]
    law = content["laws"]["l1"]
    assert (law["flights"], law["failures"], law["probability"]) == (6, 3, 0.5)
    assert law["lower"] < 0.5 < law["upper"]
    assert law["reasons"] == {"orbit_lost": 2, "raised": 1}
    assert law["errors"] == ["SimulationError: lost"]
    assert set(law["groups"]) == {"single", "together"}
    assert set(law["mistakes"]) == {"lag", "sensors", "driving"}
    assert law["quantiles"]["range_rms_m"]["1.0"] is None
    assert law["quantiles"]["range_rms_m"]["0.5"] > 0.0
    assert content["worst"][0]["flight"] == 0
    assert len(content["worst"]) == 6


def test_tables_say_how_many_failed_and_why(failing):
    shown = campaign_study(failing).tables
    head, *_ = shown["failures"].rows
    assert head[:4] == ["l1", "all", "6", "3"]
    assert head[-1] == "orbit_lost 2, raised 1"
    assert shown["worst"].rows[0][3] == "SimulationError: lost"
    assert shown["quantiles"].rows[0][:2] == ["settled [s]", "l1"]


def test_the_folder_holds_page_picture_and_the_worst_flights(results):
    folder = results.file.parent
    campaign_study(results).publish(folder)
    assert {path.name for path in folder.iterdir()} == {
        "campaign.html", "campaign.json", "campaign.png", "flights.parquet", "worst",
    }  # fmt: skip
    page = (folder / "campaign.html").read_text()
    assert "Short &lt;flights&gt;" in page
    assert "95 % bounds" in page
    assert len(list((folder / "worst").glob("*.yaml"))) == 6


def test_a_worst_flight_is_flown_again_bit_for_bit(results):
    content = as_json(results)
    campaign_study(results).publish(results.file.parent)
    worst = content["worst"][0]
    file = worst["replay"].removeprefix("uav_tracking simulate --config ")
    log = simulate(load_configuration(file))
    late = log.error[log.time >= 4.0, 0]
    (row,) = [
        row
        for row in results.rows
        if (row["flight"], row["law"]) == (worst["flight"], worst["law"])
    ]
    assert float(np.max(np.abs(late))) == row["worst_m"]
    assert float(np.sqrt(np.mean(late**2))) == row["range_rms_m"]


def test_a_failing_campaign_is_drawn(failing):
    campaign_study(failing).publish(failing.file.parent)
    assert (failing.file.parent / "campaign.png").stat().st_size > 10_000


def test_tables_go_into_a_page(results, tmp_path):
    page = tmp_path / "page.md"
    names = ("failures", "quantiles", "traits", "worst")
    page.write_text("".join(f"<!-- table {name} -->\n<!-- end -->\n" for name in names))
    campaign_study(results).publish(None, page)
    assert "| l1 | all | 6 |" in page.read_text()


def test_a_sweep_has_a_line_for_each_combination(tmp_path):
    draw = {
        "mission.duration": 5.0,
        "start.distance": 300.0,
        "nmpc_controller.range": {"values": [250.0, 300.0]},
    }
    campaign = short_campaign(
        tmp_path, draw=draw, flights=1, errors=None, groups=None, settled_after=2.0
    )
    results = run_campaign(campaign, LocalExecutor(1), tmp_path / "out", show=False)
    content = as_json(results)
    assert [part["nmpc_controller.range"] for part in content["laws"]["l1"]["swept"]] == [250, 300]
    lines = [row[1] for row in campaign_study(results).tables["failures"].rows]
    assert lines == ["all", "nmpc_controller.range = 250", "nmpc_controller.range = 300"]
    campaign_study(results).publish(tmp_path / "out")
