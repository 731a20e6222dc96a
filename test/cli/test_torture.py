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

"""A short campaign with real nodes: nothing may break."""

import json

import pytest
from processes import TERMINATE, nodes_of, outcome, scripted, started, undecided
from sources import ROOT

pytestmark = pytest.mark.nodes
TORTURE = ("cli.main", "torture")


# Where the flight begins on the orbit, nothing need be waited for.
ON_ORBIT = (
    *("--set", "uav_simulator.initial_position=[274.95454169735043, 0.0, 120.0]"),
    *("--set", "uav_simulator.initial_heading=-1.5707963267948966"),
)
BELOW_THE_TARGET = (
    *("--set", "target_publisher.position=[0, 0, 60]"),
    *("--set", "nmpc_controller.altitude=-50.0"),
    *("--set", "uav_simulator.initial_position=[141.4213562373095, 0.0, 10.0]"),
    *("--set", "uav_simulator.initial_heading=-1.5707963267948966"),
    *("--set", "uav_simulator.initial_speed=4.0"),
)
EXAMPLE = ROOT / "examples" / "add_a_fault.py"
ICED = f"{EXAMPLE}:IcedPitot"


@pytest.mark.alone
def test_faults_break_nothing(tmp_path):
    """By the example, whose fault comes before all others."""
    words = ("--minutes", 0.3, "--seed", 0, "--output", tmp_path, "--json", *ON_ORBIT)
    script = f"import runpy; runpy.run_path({str(EXAMPLE)!r}, run_name='__main__')"
    code, printed, errors = scripted(script, *words, env=undecided())
    summary = json.loads(printed)
    told = {"failing": summary["failing_cases"], "errors": errors}
    assert code == 0, told
    assert summary["violations"] == summary["deaths"] == 0, told
    assert not summary["interrupted"]
    assert summary["faults"] >= summary["kinds"] >= 5
    assert summary["worst_recovery_s"] <= 30.0
    assert summary["per_kind"]["iced_pitot"]["faults"] == 1
    assert any(kind.startswith("kill_") for kind in summary["per_kind"])
    assert json.loads((tmp_path / "torture.json").read_text()) == summary
    assert (tmp_path / "timeline.png").read_bytes().startswith(b"\x89PNG")
    assert "Traceback" not in errors + (tmp_path / "nodes.log").read_text()


@pytest.mark.long
def test_ten_minutes_of_faults_break_nothing(tmp_path):
    words = ("--minutes", 10, "--seed", 1, "--output", tmp_path, "--json")
    code, printed, errors = outcome(*TORTURE, *words, env=undecided(), limit=1100.0)
    summary = json.loads(printed)
    assert code == 0, {"failing": summary["failing_cases"], "errors": errors}
    assert summary["kinds"] == 58


def test_what_is_violated_is_found_told_and_kept(tmp_path):
    """A floor that the orbit lies below: the observer must see it, whoever is to blame."""
    from uav_tracking_mpc.nodes.bag_log import messages
    from uav_tracking_mpc.studies.faults.observer import TOPICS

    words = ("--minutes", 1, "--seed", 1, "--case", 0, "--fault", ICED)
    where = ("--config", "paper", "--output", tmp_path, *BELOW_THE_TARGET)
    code, output, errors = outcome(*TORTURE, *words, *where, env=undecided())
    assert code == 1, errors
    assert "case 0 (iced_pitot): altitude floor" in output
    (bag,) = (tmp_path / "cases").glob("case_0000.mcap")
    heard = {topic.name for topic, _, _ in messages(bag, *TOPICS)}
    assert {"raw/uav/odometry", "uav/odometry", "raw/uav/command", "torture/fault"} <= heard


def test_a_campaign_may_be_ended_tells_what_it_found_and_leaves_nobody(tmp_path):
    words = ("--minutes", 30, "--seed", 2, "--output", tmp_path, *ON_ORBIT)
    with started(*TORTURE, *words, after="case    0", env=undecided(), apart=True) as process:
        assert len(nodes_of(process.pid)) == 3
        process.send_signal(TERMINATE)
        printed, errors = process.communicate(timeout=900)
    assert process.returncode == 130
    assert not nodes_of(process.pid)
    summary = json.loads((tmp_path / "torture.json").read_text())
    assert summary["interrupted"]
    assert summary["cases"] >= 1
    assert f"in {summary['cases']} cases" in printed
    assert "interrupted: " in errors.strip().splitlines()[-1]
