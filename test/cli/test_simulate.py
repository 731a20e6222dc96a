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

"""A mission without ROS from the command line."""

import json

import pytest


def test_json_is_one_object_and_the_report_is_written(tmp_path, uav_tracking):
    metrics = uav_tracking.json("simulate", "--duration", 40, "--output", tmp_path / "out")
    assert metrics["config"] == "paper"
    assert metrics["settling_s"]["altitude"] == 16.0
    assert json.loads((tmp_path / "out" / "metrics.json").read_text()) == metrics
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"metrics.json", "trajectory.png", "states.png", "report.html"}


@pytest.mark.usefixtures("without_report")
def test_people_are_told_in_three_lines(tmp_path, uav_tracking):
    told = uav_tracking.told("simulate", "--duration", 40, "--output", tmp_path)
    lines = told.splitlines()
    assert lines[0].startswith("settled: range 20.0 s")
    assert lines[-1] == f"report: {tmp_path / 'report.html'}"


def test_a_mission_shorter_than_a_step_is_one_step(tmp_path, uav_tracking):
    few = ("--duration", 1, "--set", "nmpc_controller.horizon_step=5", "--output", tmp_path)
    uav_tracking.told("simulate", *few, "--set", "nmpc_controller.solver=ipopt")


@pytest.mark.usefixtures("without_report")
def test_another_law_flies_in_the_place_of_the_controller(tmp_path, uav_tracking):
    few = ("--config", "small_uav", "--duration", 5, "--output", tmp_path)
    assert uav_tracking.json("simulate", *few, "--law", "l1")["solver"]["name"] == "none"


FAILING = """
from uav_tracking_mpc import GuidanceLaw

class Failing(GuidanceLaw):
    name = "failing"

    def inputs(self, situation):
        return {answer}
"""


@pytest.mark.usefixtures("without_report")
@pytest.mark.parametrize(
    ("answer", "reason"),
    [("1 / 0", "ZeroDivisionError: division by zero"), ("[float('nan')] * 3", "answered [nan,")],
)
def test_a_law_that_never_answers_is_no_good_flight(answer, reason, tmp_path, uav_tracking):
    path = tmp_path / "failing.py"
    path.write_text(FAILING.format(answer=answer))
    words = ("simulate", "--config", "small_uav", "--duration", 5, "--law", f"{path}:Failing")
    ended = uav_tracking(*words, "--output", tmp_path)
    assert ended.code == 1
    assert reason in ended.err.splitlines()[-1]
    assert ended.out.startswith("the law answered none of ")
    assert reason in ended.out
    assert "settled" not in ended.out
    ended = uav_tracking(*words, "--output", tmp_path, "--json")
    assert ended.code == 1
    assert reason in json.loads(ended.out)["not_by_law"]


@pytest.mark.parametrize("command", ["simulate", "fly"])
@pytest.mark.parametrize(
    "told", [["--law", "nofile.py:X"], ["--set", "nmpc_controller.law=nofile.py:X"]]
)
def test_a_law_that_is_not_there_is_said_once_before_anything_flies(
    command, told, tmp_path, uav_tracking, caplog
):
    refusal = uav_tracking.refused(command, *told, "--output", tmp_path / "out")
    assert (refusal + caplog.text).count("nofile.py") == 1
    assert not (tmp_path / "out").exists()
