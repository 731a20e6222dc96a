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

"""What people get: tables, a picture, a page, and the worst flights to look at again."""

import json
from dataclasses import replace

import numpy as np
import pytest
from campaign_files import short_campaign

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies.campaign.campaign_page import tables, write_campaign, write_into
from uav_tracking_mpc.studies.campaign.campaign_results import as_json
from uav_tracking_mpc.studies.campaign.campaign_run import run_campaign
from uav_tracking_mpc.studies.campaign.executors import LocalExecutor


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
    shown = tables(failing)
    head, *_ = shown["Failures"].rows
    assert head[:4] == ["l1", "all", "6", "3"]
    assert head[-1] == "orbit_lost 2, raised 1"
    assert shown["The worst flights"].rows[0][3] == "SimulationError: lost"
    assert shown["Quantiles"].rows[0][:2] == ["settled [s]", "l1"]


def test_the_folder_holds_page_picture_and_the_worst_flights(results):
    folder = results.file.parent
    write_campaign(as_json(results), results)
    assert {path.name for path in folder.iterdir()} == {
        "campaign.html", "campaign.json", "campaign.png", "flights.parquet", "worst",
    }  # fmt: skip
    page = (folder / "campaign.html").read_text()
    assert "Short &lt;flights&gt;" in page
    assert "95 % bounds" in page
    assert len(list((folder / "worst").glob("*.yaml"))) == 6


def test_a_worst_flight_is_flown_again_bit_for_bit(results):
    content = as_json(results)
    write_campaign(content, results)
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
    write_campaign(as_json(failing), failing)
    assert (failing.file.parent / "campaign.png").stat().st_size > 10_000


def test_tables_go_into_a_page(results, tmp_path):
    page = tmp_path / "page.md"
    names = ("failures", "quantiles", "traits", "worst")
    page.write_text("".join(f"<!-- table {name} -->\n<!-- end -->\n" for name in names))
    write_into(page, results)
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
    lines = [row[1] for row in tables(results)["Failures"].rows]
    assert lines == ["all", "nmpc_controller.range = 250", "nmpc_controller.range = 300"]
    write_campaign(content, results)
