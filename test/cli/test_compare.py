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

"""The command from end to end, and what it refuses."""

import json

import pytest
from example_flights import KEYS

from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.studies import executors
from uav_tracking_mpc.studies.comparison import results

LAW = """
import numpy as np
from uav_tracking_mpc.laws import GuidanceLaw

class Circler(GuidanceLaw):
    name = "circler"

    def inputs(self, situation):
        return np.array([self.orbit.speed / self.orbit.radius, 0.0, 0.0])
"""


@pytest.fixture
def in_this_process(monkeypatch):
    """Others would import everything anew: test/studies/comparison/test_scenarios.py has some."""
    monkeypatch.setattr(executors.os, "sched_getaffinity", lambda _: {0})


@pytest.mark.usefixtures("in_this_process")
def test_two_laws_through_one_scenario(tmp_path, uav_tracking):
    content = uav_tracking.json(
        "compare", "--config", "small_uav", "--scenario", "wind", "--laws", "nmpc", "l1",
        "--set", "mission.duration=30", "--output", tmp_path,
    )  # fmt: skip
    flights = content["scenarios"]["wind"]
    assert list(flights) == ["nmpc", "l1"]
    assert all(set(flight) == KEYS for flight in flights.values())
    assert flights["nmpc"]["settling_s"] < 25.0
    assert flights["nmpc"]["range_rms_m"] < 10.0
    assert json.loads((tmp_path / "compare.json").read_text()) == content
    assert (tmp_path / "wind.png").is_file()
    assert (tmp_path / "compare.html").is_file()


def test_people_get_a_table(uav_tracking):
    few = ("--scenario", "still", "--laws", "l1", "--set", "mission.duration=5")
    told = uav_tracking.told("compare", *few)
    assert "range RMS" in told
    assert "never" in told
    assert "missed" not in told  # without the controller nothing is judged


class Interrupting:
    """Flies, and is interrupted at some flight."""

    def __init__(self, at):
        self.left = at

    def __call__(self, configuration):
        self.left -= 1
        if not self.left:
            raise KeyboardInterrupt
        return simulate(configuration)


@pytest.fixture
def interrupted(monkeypatch, in_this_process, uav_tracking):
    """Compares two laws, and is interrupted at some flight; what it says then."""

    def interrupted(at, *words):
        monkeypatch.setattr(results, "simulate", Interrupting(at))
        laws = ("--laws", "l1", "vector_field", "--set", "mission.duration=5")
        ended = uav_tracking("compare", *laws, *words)
        assert ended.code == 130
        return ended.err.strip()

    return interrupted


def test_an_interrupted_comparison_keeps_the_scenarios_that_were_flown(interrupted, tmp_path):
    words = interrupted(4, "--scenario", "still", "wind", "--output", tmp_path)
    assert "interrupted: 1 of 2 were flown by every law" in words
    content = json.loads((tmp_path / "compare.json").read_text())
    assert {name: set(laws) for name, laws in content["scenarios"].items()} == {
        "still": {"l1", "vector_field"}
    }
    assert (tmp_path / "compare.html").is_file()


def test_interrupted_mismatches_are_kept(interrupted, tmp_path):
    interrupted(3, "--mismatch", "lag_0", "lag_2", "--output", tmp_path)
    content = json.loads((tmp_path / "mismatches.json").read_text())
    assert list(content["mismatches"]) == ["lag_0"]


def test_before_any_scenario_is_whole_there_is_nothing_to_keep(interrupted, tmp_path):
    words = interrupted(2, "--scenario", "still", "wind", "--output", tmp_path / "out")
    assert words.endswith("uav_tracking: interrupted")
    assert not (tmp_path / "out" / "compare.json").exists()


def test_a_law_of_ones_own_flies_beside_the_others(tmp_path, uav_tracking):
    path = tmp_path / "circler.py"
    path.write_text(LAW)
    content = uav_tracking.json(
        "compare", "--scenario", "still", "--laws", "l1", "--law", f"{path}:Circler",
        "--set", "mission.duration=5", "--output", tmp_path / "out",
    )  # fmt: skip
    assert "commands that count" not in (tmp_path / "out" / "compare.html").read_text()
    assert list(content["scenarios"]["still"]) == ["l1", "circler"]
    assert (tmp_path / "out" / "still.png").is_file()


@pytest.mark.usefixtures("in_this_process")
def test_a_law_that_fails_is_not_what_its_figures_are_of(tmp_path, uav_tracking):
    path = tmp_path / "circler.py"
    path.write_text(LAW.replace("return np.array(", "raise RuntimeError("))
    words = ("--scenario", "still", "--laws", "l1", "--law", f"{path}:Circler")
    told = uav_tracking.told("compare", *words, "--set", "mission.duration=5", "--output", tmp_path)
    assert "still: circler: the law answered none of " in told
    assert "the law circler failed: RuntimeError" in told
    (row,) = (line for line in told.splitlines() if line.split()[:1] == ["circler"])
    assert set(row.split()[1:]) == {"\u2013"}
    figures = json.loads((tmp_path / "compare.json").read_text())["scenarios"]["still"]["circler"]
    assert set(figures) == KEYS
    assert figures.pop("off_plan") > 0
    assert set(figures.values()) == {None}


@pytest.mark.usefixtures("in_this_process")
def test_a_page_without_a_place_for_the_table_costs_no_flight(tmp_path, uav_tracking):
    page = tmp_path / "page.md"
    page.write_text("words")
    law = ("--laws", "l1", "--set", "mission.duration=5")
    ended = uav_tracking("compare", "--scenario", "still", *law, "--page", page)
    assert ended.code == 2 and "page.md has no place" in ended.err
    assert "range RMS" in ended.out


@pytest.mark.usefixtures("in_this_process")
def test_an_option_that_is_repeated_adds_to_itself(uav_tracking):
    content = uav_tracking.json(
        "compare", "--scenario", "wind", "--scenario", "still", "--laws", "l1", "--laws", "npfg",
        "--set", "mission.duration=5",
    )  # fmt: skip
    assert {name: set(laws) for name, laws in content["scenarios"].items()} == {
        "wind": {"l1", "npfg"}, "still": {"l1", "npfg"}
    }  # fmt: skip


def test_scenarios_of_one_name_are_refused(tmp_path, uav_tracking):
    (tmp_path / "still.yaml").write_text("{}")
    ended = uav_tracking("compare", "--scenario", "still", tmp_path / "still.yaml")
    assert ended.code == 2
    assert "each must have a name of its own" in ended.err


@pytest.mark.usefixtures("in_this_process")
def test_laws_that_are_told_wrong(tmp_path, uav_tracking):
    content = uav_tracking.json(
        "compare", "--mismatch", "zigzag", "lag_0.5", "--laws", "nmpc", "npfg",
        "--set", "mission.duration=20", "--output", tmp_path,
    )  # fmt: skip
    assert list(content["mismatches"]) == ["lag_0.5", "zigzag"]
    for flown in content["mismatches"].values():
        assert list(flown) == ["nmpc", "npfg"]
        assert all(set(flight) == KEYS for flight in flown.values())
    assert content["asked"]["lag_0.5"]["range_rms_m"] == 0.5
    assert content["asked"]["zigzag"]["of_law"] == "npfg"
    assert json.loads((tmp_path / "mismatches.json").read_text()) == content
    assert (tmp_path / "mismatches.png").is_file()
