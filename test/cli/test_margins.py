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

"""The command, with flights as the model has them: what it prints, writes and refuses."""

import json

import numpy as np
import pytest
import yaml

from uav_tracking_mpc.margins.orbit_loop import OrbitLoop
from uav_tracking_mpc.studies.margins import margin_study, weight_search
from uav_tracking_mpc.studies.margins.margin_study import FlownLoop


@pytest.fixture(autouse=True)
def no_flights(monkeypatch):
    def flown_loops(configuration, frequency, sizes, workers, show):
        near = OrbitLoop(configuration.controller)
        loop = near.loop(near.orbit_in(np.zeros(3))).response(frequency)
        return [FlownLoop(loop, True) for _ in sizes]

    monkeypatch.setattr(margin_study, "flown_loops", flown_loops)
    monkeypatch.setattr(margin_study, "AZIMUTHS", 2)


def test_json_and_files(tmp_path, uav_tracking):
    page = tmp_path / "page.md"
    page.write_text("<!-- table margins -->\n<!-- end -->\n")
    where = ("--output", tmp_path, "--page", page)
    content = uav_tracking.json("margins", "--config", "small_uav", *where)
    assert set(content["channels"]) == {"turn", "path", "speed"}
    assert content["wind"]["drift_mps"] == [-5.0, 8.0, 0.0]  # of crosswind
    assert json.loads((tmp_path / "margins.json").read_text()) == content
    assert (tmp_path / "margins.png").is_file()
    assert "| turn |" in page.read_text()


def test_the_papers_controller_knows_no_wind(uav_tracking):
    assert uav_tracking.json("margins", "--config", "paper")["wind"] is None


def test_people_are_told_what_is_too_small(uav_tracking):
    asked = ("--scenario", "still", "--set", "nmpc_controller.gain_margin_min=60.0")
    out = uav_tracking.told("margins", *asked)
    assert "gain up" in out
    assert "too small, still air, turn bears" in out


def test_a_drift_in_which_no_plan_holds_the_orbit_is_told(uav_tracking):
    ended = uav_tracking("margins", "--set", "uav_simulator.wind=[40,0,0]", "--scenario", "still")
    assert ended.code == 2
    assert "no plan holds the orbit in a drift of 40 m/s: the target moves through" in ended.err


def test_a_search_prints_what_to_paste(monkeypatch, tmp_path, uav_tracking):
    weights = tuple(float(each) for each in range(1, 15))
    best, given = weight_search.Candidate(weights, 0.4, 9.0, [], {}, 1.0), []
    monkeypatch.setattr(
        weight_search,
        "search_weights",
        lambda config, overrides: (
            given.append(overrides)
            or weight_search.search_study(config, [best], best, "one weight was tried")
        ),
    )
    words = ("margins", "--search", "--limit", "fence", "--output", tmp_path)
    ended = uav_tracking(*words)
    assert (ended.code, ended.err) == (130, "interrupted: one weight was tried\n")
    assert given == [['nmpc_controller.limits="fence"']]
    assert "leave out --scenario" in uav_tracking(*words, "--scenario", "wind").err
    pasted = yaml.safe_load(ended.out[ended.out.index("/**") :])
    assert pasted["/**/nmpc_controller"]["ros__parameters"]["rate_weights"] == [9.0, 10.0, 11.0]
    assert json.loads((tmp_path / "search.json").read_text())["best"]["cost"] == 1.0
