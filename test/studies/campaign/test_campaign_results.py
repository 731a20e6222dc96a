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
from types import SimpleNamespace

import numpy as np
import pytest
from campaign_files import short_campaign
from scipy import stats

from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.campaign.campaign_results import (
    as_json,
    bounds,
    campaign_study,
    common_traits,
    quantiles,
    swept_parts,
    trait_table,
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


def test_bounds_of_few_failures_and_where_none_or_all_fail():
    assert bounds(2000, 3)["upper"] < 0.004 < bounds(2000, 4)["upper"]
    none, every = bounds(100, 0), bounds(100, 100)
    assert (none["lower"], none["upper"]) == (0.0, pytest.approx(1.0 - 0.05**0.01))
    assert (every["lower"], every["upper"]) == (pytest.approx(0.05**0.01), 1.0)


@pytest.mark.parametrize("probability", [0.002, 0.05, 0.5])
def test_bounds_hold_as_often_as_they_claim(probability):
    """Summed over all that can happen: that is exact."""
    happens = stats.binom.pmf(np.arange(201), 200, probability)
    every = [bounds(200, count) for count in range(201)]
    upper, lower = (np.array([each[side] for each in every]) for side in ("upper", "lower"))
    assert happens[upper >= probability].sum() >= 0.95
    assert happens[lower <= probability].sum() >= 0.95


@pytest.fixture
def rows():
    """Of flights: those that failed had strong wind and a zigzag."""
    random = np.random.default_rng(0)
    found = [
        {
            "flight": number,
            "wind": float(random.uniform(0.0, 10.0)),
            "noise": float(random.uniform(0.0, 1.0)),
            "motion": str(random.choice(["line", "zigzag", "circle"])),
            "constant": 1.0,
        }
        for number in range(300)
    ]
    for row in found:
        row["failed"] = row["wind"] > 8.0 and row["motion"] == "zigzag"
    return found


def test_what_failures_have_in_common_is_found(rows):
    inputs = ["wind", "noise", "motion", "constant"]
    wind, motion = common_traits(rows, inputs, lambda row: row["failed"])
    assert wind["input"] == "wind"
    assert 7.9 <= float(wind["rule"].removeprefix("> ")) < 8.1
    assert (motion["input"], motion["rule"]) == ("motion", "= zigzag")
    assert wind["share"] == motion["share"] == 1.0
    assert max(wind["p_value"], motion["p_value"]) < 0.05
    (small,) = common_traits(rows, ["wind"], lambda row: row["wind"] < 2.0)
    assert small["rule"].startswith("<= 1.9")
    assert (small["share"], small["others"]) == (1.0, 0.0)


@pytest.mark.parametrize(
    "chosen", [lambda row: row["flight"] % 10 == 0, lambda row: row["flight"] < 2]
)
def test_chance_is_not_told_and_two_failures_have_nothing_to_tell(rows, chosen):
    assert common_traits(rows, ["wind", "noise", "motion"], chosen) == []


@pytest.mark.parametrize(
    ("rule", "words"), [("> 1.2e+04", "x > 1.2e+04"), ("= lag+sensors", "x = lag + sensors")]
)
def test_errors_that_came_together_are_told_apart_and_numbers_are_whole(rule, words):
    trait = {"input": "x", "rule": rule, "share": 1.0, "others": 0.0, "p_value": 0.01}
    found = {"l1": {"failed_have_in_common": [trait], "worst_have_in_common": []}}
    (row,) = trait_table(found).rows
    assert row[2] == words


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
    fallen = [{**row, "off_plan": 3 * (row["flight"] == 1)} for row in failing.rows]
    study = campaign_study(replace(failing, rows=fallen))
    assert "l1: in 1 flights a fallback mode flew at times" in study.words
    head, *_ = study.tables["failures"].rows
    assert head[:4] == ["l1", "all", "6", "3"]
    assert head[-1] == "orbit_lost 2, raised 1"
    assert study.tables["worst"].rows[0][3] == "SimulationError: lost"
    assert study.tables["quantiles"].rows[0][:2] == ["settled [s]", "l1"]
    figure = study.figures["campaign"]()
    assert png(figure)
    label = figure.axes[0].yaxis.label.get_window_extent()
    assert label.x0 >= 0.0  # of few flights, too, it stands in the picture


def test_the_folder_holds_page_picture_and_the_worst_flights_to_be_flown_again(results, tmp_path):
    """A worst flight flies again bit for bit; tables go into a page of the documentation."""
    study, folder, page = campaign_study(results), results.file.parent, tmp_path / "page.md"
    page.write_text("".join(f"<!-- table {name} -->\n<!-- end -->\n" for name in study.tables))
    study.publish(folder)
    study.document(page)
    assert set(study.tables) == {"failures", "quantiles", "traits", "worst"}
    assert "| l1 | all | 6 |" in page.read_text()
    assert {path.name for path in folder.iterdir()} == {
        "campaign.html", "campaign.json", "campaign.png", "flights.parquet", "worst",
    }  # fmt: skip
    html = (folder / "campaign.html").read_text()
    assert "Short &lt;flights&gt;" in html
    assert "95 % bounds" in html
    assert len(list((folder / "worst").glob("*.yaml"))) == 6
    worst = study.content["worst"][0]
    log = simulate(
        load_configuration(worst["replay"].removeprefix("uav_tracking simulate --config "))
    )
    late = log.error[log.time >= 4.0, 0]
    key = worst["flight"], worst["law"]
    (row,) = [row for row in results.rows if (row["flight"], row["law"]) == key]
    assert float(np.max(np.abs(late))) == row["worst_m"]
    assert float(np.sqrt(np.mean(late**2))) == row["range_rms_m"]


def test_a_sweep_has_a_line_for_each_combination(tmp_path):
    draw = {
        "mission.duration": 5.0,
        "start.distance": 300.0,
        "nmpc_controller.range": {"values": [250.0, 300.0]},
    }
    campaign = short_campaign(
        tmp_path, draw=draw, flights=1, errors=None, groups=None, settled_after=2.0
    )
    study = campaign_study(run_campaign(campaign, LocalExecutor(1), tmp_path, show=False))
    swept = study.content["laws"]["l1"]["swept"]
    assert [part["nmpc_controller.range"] for part in swept] == [250, 300]
    lines = [row[1] for row in study.tables["failures"].rows]
    assert lines == ["all", "nmpc_controller.range = 250", "nmpc_controller.range = 300"]
    assert png(study.figures["campaign"]())


def test_an_interrupted_sweep_keeps_its_flights_apart(results):
    campaign = SimpleNamespace(swept=("wind",), flights=3)
    rows = [{"flight": flight} for flight in (0, 2, 3, 4, 5, 7)]
    parts = swept_parts(replace(results, campaign=campaign), rows)
    assert [[row["flight"] for row in part] for part in parts] == [[0, 2], [3, 4, 5], [7]]
