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
import subprocess

import pytest
from processes import TERMINATE, command, nodes_of, undecided, wait_for

pytestmark = pytest.mark.nodes


def torture(*arguments):
    return subprocess.Popen(
        command("cli.main", "torture", *map(str, arguments)),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=undecided(),
    )


# Where the flight begins on the orbit, nothing need be waited for.
ON_ORBIT = (
    "uav_simulator.initial_position=[274.95454169735043, 0.0, 120.0]",
    "uav_simulator.initial_heading=-1.5707963267948966",
)
BELOW_THE_TARGET = (
    "target_publisher.position=[0, 0, 60]",
    "nmpc_controller.altitude=-50.0",
    "uav_simulator.initial_position=[141.4213562373095, 0.0, 10.0]",
    "uav_simulator.initial_heading=-1.5707963267948966",
    "uav_simulator.initial_speed=4.0",
)
STUCK_TARGET = """
from uav_tracking_mpc.nodes.topics import TARGET
from uav_tracking_mpc.studies.faults.stream_fault import StreamFault

class Stuck(StreamFault):
    name, family, duration, streams = "stuck_target", "target", (0.5, 1.0), (TARGET,)
    latest = None

    def deliver(self, topic, data):
        self.latest = self.latest or data
        return [(0.0, self.latest)]
"""


def setting(assignments):
    return [word for assignment in assignments for word in ("--set", assignment)]


@pytest.mark.alone
def test_faults_break_nothing(tmp_path):
    file, output = tmp_path / "stuck.py", tmp_path / "output"
    file.write_text(STUCK_TARGET)
    process = torture(
        *("--minutes", 0.3, "--seed", 0, "--fault", f"{file}:Stuck", "--output", output, "--json"),
        *setting(ON_ORBIT),
    )
    printed, errors = process.communicate(timeout=300)
    summary = json.loads(printed)
    told = {"failing": summary["failing_cases"], "errors": errors}
    assert process.returncode == 0, told
    assert summary["violations"] == summary["deaths"] == 0, told
    assert not summary["interrupted"]
    assert summary["faults"] >= summary["kinds"] >= 5
    assert summary["worst_recovery_s"] <= 30.0
    assert "stuck_target" in summary["per_kind"]
    assert any(kind.startswith("kill_") for kind in summary["per_kind"])
    assert json.loads((output / "torture.json").read_text()) == summary
    assert (output / "timeline.png").read_bytes().startswith(b"\x89PNG")
    assert "Traceback" not in errors + (output / "nodes.log").read_text()


@pytest.mark.long
@pytest.mark.timeout(1200)
def test_ten_minutes_of_faults_break_nothing(tmp_path):
    process = torture("--minutes", 10, "--seed", 1, "--output", tmp_path, "--json")
    printed, errors = process.communicate(timeout=1100)
    summary = json.loads(printed)
    assert process.returncode == 0, {"failing": summary["failing_cases"], "errors": errors}
    assert summary["kinds"] == 58


def test_what_is_violated_is_found_told_and_kept(tmp_path):
    """A floor that the orbit lies below: the observer must see it, whoever is to blame."""
    from uav_tracking_mpc.nodes.bag.bag_log import messages
    from uav_tracking_mpc.studies.faults.observer import TOPICS

    file = tmp_path / "stuck.py"
    file.write_text(STUCK_TARGET)
    process = torture(
        *("--minutes", 1, "--seed", 1, "--case", 0, "--fault", f"{file}:Stuck"),
        *("--config", "paper", "--output", tmp_path),
        *setting(BELOW_THE_TARGET),
    )
    output, errors = process.communicate(timeout=300)
    assert process.returncode == 1, errors
    assert "case 0 (stuck_target): altitude floor" in output
    (bag,) = (tmp_path / "cases").glob("case_0000.mcap")
    heard = {topic.name for topic, _, _ in messages(bag, *TOPICS)}
    assert {"raw/uav/odometry", "uav/odometry", "raw/uav/command", "torture/fault"} <= heard


def test_a_campaign_may_be_ended_and_leaves_nobody(tmp_path):
    process = torture("--minutes", 5, "--output", tmp_path)
    try:
        assert wait_for(lambda: len(nodes_of(process.pid)) == 3)
        nodes = nodes_of(process.pid)
        process.send_signal(TERMINATE)
        _, errors = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 130, errors
    assert errors.strip().endswith("uav_tracking: interrupted")
    assert not nodes_of(process.pid)
    assert len(nodes) == 3


def test_what_was_found_before_the_end_is_told(tmp_path):
    process = torture("--minutes", 30, "--seed", 2, "--output", tmp_path, *setting(ON_ORBIT))
    try:
        assert any("case    0" in line for line in process.stderr)
        process.send_signal(TERMINATE)
        printed, errors = process.communicate(timeout=300)
    finally:
        process.kill()
    assert process.returncode == 130
    summary = json.loads((tmp_path / "torture.json").read_text())
    assert summary["interrupted"]
    assert summary["cases"] >= 1
    assert f"in {summary['cases']} cases" in printed
    assert "interrupted: " in errors.strip().splitlines()[-1]
