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
import subprocess
import sys

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.studies.faults.catalogue import catalogue, variants

OF_TOPIC = ("nan", "inf", "huge", "frame", "old_stamp", "future_stamp", "duplicated", "reordered")
EXPECTED = {
    *(f"{action}_{node}" for action in ("kill", "stop") for node in NODES),
    *(
        f"{topic}_{word}"
        for topic in ("odometry", "target", "command", "air_velocity")
        for word in OF_TOPIC
    ),
    *(f"odometry_{word}" for word in ("quaternion", "negative_speed", "absurd")),
    *("target_absurd", "command_absurd", "command_empty", "air_velocity_negative_speed"),
    *("cpu_starvation", "loss", "jitter", "gap_state", "gap_target", "gap_command"),
    *("target_teleport", "target_lost", "clock_forward", "clock_backward", "clock_pause"),
    *("parameter_storm", "solver_budget"),
}
STUCK = """
from uav_tracking_mpc.nodes.topics import TARGET
from uav_tracking_mpc.studies.faults.stream_fault import StreamFault

class Stuck(StreamFault):
    name = {name!r}
    family = "target"
    duration = (1.0, 3.0)
    streams = (TARGET,)

    def deliver(self, topic, data):
        return []
"""


def test_every_fault_has_a_label_and_each_object_is_its_own():
    faults = catalogue()
    assert set(faults) == EXPECTED
    assert len(EXPECTED) == 58
    assert all(label == fault.label for label, fault in faults.items())
    assert catalogue()["loss"] is not faults["loss"]
    families = [fault.family for fault in faults.values()]
    assert sorted(families) == families


def test_a_fault_of_an_outside_file_is_found_here_and_in_another_process(tmp_path):
    file = tmp_path / "stuck.py"
    file.write_text(STUCK.format(name="stuck_target"))
    reference = f"{file}:Stuck"
    fault = catalogue([reference])["stuck_target"]
    program = (
        "import json, sys; from uav_tracking_mpc.studies.faults.catalogue import variants;"
        "print(json.dumps(list(variants(sys.argv[1]))))"
    )
    finished = subprocess.run(
        [sys.executable, "-c", program, fault.reference], capture_output=True, text=True
    )
    assert json.loads(finished.stdout) == ["stuck_target"], finished.stderr


def test_two_faults_of_one_label_are_told(tmp_path):
    file = tmp_path / "stuck.py"
    file.write_text(STUCK.format(name="target_lost"))
    with pytest.raises(ExtensionError, match="'target_lost' of fault 'target_lost'"):
        catalogue([f"{file}:Stuck"])


def test_what_is_no_fault_is_told():
    with pytest.raises(ExtensionError, match=r"fault is 'banana', must be one of absurd, "):
        variants("banana")
