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

"""The study of a configuration: numbers, table and figure; flights are those of the model."""

import json
import math

import numpy as np
import pytest

from uav_tracking_mpc.control.loop_margins import UNSTABLE
from uav_tracking_mpc.control.orbit_loop import OrbitLoop
from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.margins import margin_study as module
from uav_tracking_mpc.studies.margins.flown_loop import FlownLoop
from uav_tracking_mpc.studies.margins.margin_figure import margin_figure
from uav_tracking_mpc.studies.margins.margin_study import as_json, margin_study
from uav_tracking_mpc.studies.margins.margin_table import margin_table


def modelled(settled=True):
    def flown_loops(configuration, frequency, sizes, workers, show):
        near = OrbitLoop(configuration.controller)
        loop = near.loop(near.orbit_in(np.zeros(3))).response(frequency)
        return [FlownLoop(loop, settled) for _ in sizes]

    return flown_loops


@pytest.fixture(scope="module")
def study():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "flown_loops", modelled())
        patch.setattr(module, "AZIMUTHS", 4)
        return margin_study(load_configuration("small_uav", scenario="crosswind"))


def test_the_contract(study):
    content = json.loads(json.dumps(as_json(study), allow_nan=False))
    for name in ("turn", "path", "speed"):
        channel = content["channels"][name]
        assert channel["delay_s"] >= 0.3
        assert channel["gain_db"] >= 6.0
        assert 0.0 < channel["phase_deg"] <= 180.0
        assert content["wind"]["channels"][name]["delay_s"] >= 0.3
    assert 0.0 < content["disk"] < 2.0
    assert content["config"] == "small_uav"
    assert content["shortfalls"] == []


def test_the_drift_is_that_of_wind_and_target(study):
    np.testing.assert_allclose(study.drift, [-5.0, 8.0, 0.0])
    assert len(study.in_wind) == 4


def test_the_worst_of_the_orbit(study):
    disks = [each.disk for each in study.in_wind]
    assert study.worst.disk == min(disks)
    worst = as_json(study)["wind"]["worst_phase_deg"]
    assert worst == pytest.approx(math.degrees(study.azimuths[int(np.argmin(disks))]))


def test_the_table_has_a_row_for_each(study):
    text = margin_table(study).as_markdown()
    assert text.count("| turn |") == 3
    assert text.count("| all |") == 3


def test_the_figure_is_drawn(study):
    figure = margin_figure(study)
    chart, around = figure.axes
    assert len(chart.lines) >= 7
    assert len(around.lines) >= 7
    assert png(figure)[:4] == b"\x89PNG"


def test_answers_that_do_not_die_away_have_no_margin(monkeypatch):
    monkeypatch.setattr(module, "flown_loops", modelled(settled=False))
    found = margin_study(load_configuration("small_uav"))
    assert found.flown is UNSTABLE
    assert found.worst is None  # in still air
    content = as_json(found)
    assert content["wind"] is None
    assert content["channels"]["turn"]["gain_db"] == 0.0
    assert content["channels"]["turn"]["crossover_rad_s"] is None
    assert len(content["shortfalls"]) == 6
    margin_figure(found)
