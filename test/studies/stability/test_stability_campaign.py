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

"""Maps of X_N on a coarse grid, and flights from X_f that show what was proved."""

import numpy as np

from uav_tracking_mpc.studies.stability import stability_campaign
from uav_tracking_mpc.studies.stability.stability_campaign import (
    attraction_map,
    default_slices,
    fly_local,
    fly_nmpc,
    random_states,
    save_maps,
)
from uav_tracking_mpc.terminal.ingredients import PAPER_INITIAL_STATE, paper_problem

PROBLEM, LEVEL = paper_problem(), 2.87
SMALL = {
    "coordinates": ["range", "speed"],
    "first": np.array([150.0, 212.83]),
    "second": np.array([0.0, 4.0]),
    "base": PAPER_INITIAL_STATE,
}


def mapped(level, horizon):
    return attraction_map(PROBLEM, level, SMALL, horizon, workers=1)


def test_papers_start_is_infeasible_at_10_and_feasible_at_20():
    answers = {n: mapped(LEVEL, n) for n in (10, 20)}
    assert not answers[10]["marked_feasible"]
    assert answers[20]["marked_feasible"]
    assert np.all(answers[20]["feasible"] >= answers[10]["feasible"])


def test_slices_vary_what_they_say(monkeypatch):
    bearings, speeds = default_slices(PROBLEM, 5)
    assert bearings["coordinates"] == ["range", "bearing"]
    assert speeds["coordinates"] == ["range", "speed"]
    rows = []

    def noted(function, pieces, *options):
        rows.extend(states for _, _, states in pieces)
        return [np.zeros(len(states)) for states in rows]

    monkeypatch.setattr(stability_campaign, "parallel_map", noted)
    attraction_map(PROBLEM, LEVEL, bearings, 10)
    assert rows[1][2, 0] == bearings["first"][1]
    assert rows[1][2, 1] == bearings["second"][2]
    assert rows[1][2, 4] == PAPER_INITIAL_STATE[4]
    np.testing.assert_array_equal(rows[-1], [PAPER_INITIAL_STATE])


def test_without_terminal_set_everything_is_feasible_and_comes_back_from_the_archive(tmp_path):
    found = mapped(None, 10)
    assert found["feasible"].all()
    with (tmp_path / "maps.npz").open("wb") as file:
        save_maps([found], file)
    stored = np.load(tmp_path / "maps.npz")
    np.testing.assert_array_equal(stored["0_feasible"], found["feasible"])
    assert {name.partition("_")[2] for name in stored} == {
        "horizon", "coordinates", "first", "second", "base", "feasible", "cost", "marked",
        "marked_feasible",
    }  # fmt: skip


def test_what_is_proved_is_flown():
    result = fly_local(PROBLEM, LEVEL, random_states(PROBLEM, LEVEL, 2000))
    assert (result["clean"], result["flights"]) == (True, 2000)
    states = random_states(PROBLEM, LEVEL, 20, seed=5)
    assert fly_nmpc(PROBLEM, LEVEL, states, workers=1)["clean"]


def test_campaign_sees_a_level_that_is_too_large():
    result = fly_local(PROBLEM, 40.0, random_states(PROBLEM, 40.0, 2000), steps=3)
    assert result["outside_inputs"] > 0
    assert not result["clean"]
