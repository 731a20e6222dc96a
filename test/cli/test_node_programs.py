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

"""The executables of the nodes: found by their names, and without ROS one line and code 2."""

from pathlib import Path

import pytest
from processes import scripted

from uav_tracking_mpc.cli import node_programs

ROOT = Path(__file__).parents[2]
NODES = ("uav_simulator", "target_publisher", "nmpc_controller", "autopilot_link", "monitor")


def test_every_node_has_its_program():
    text = (ROOT / "setup.py").read_text()
    for name in NODES:
        assert f"{name} = {{NAME}}.cli.node_programs:{name}" in text
        assert callable(getattr(node_programs, name))


def test_it_ends_with_the_code_of_its_node(monkeypatch):
    monkeypatch.setattr("uav_tracking_mpc.nodes.ros.process.run", lambda name, create: 5)
    with pytest.raises(SystemExit) as ended:
        node_programs.monitor()
    assert ended.value.code == 5


@pytest.mark.parametrize("name", NODES)
def test_without_ros_one_line_and_code_2(name):
    program = f"from uav_tracking_mpc.cli.node_programs import {name} as node; sys.exit(node())"
    code, _, errors = scripted(program, missing=("rclpy",))
    assert (code, errors.count("\n")) == (2, 1), errors
    assert errors.startswith(f"{name}: rclpy is not installed; flying needs ROS 2 Jazzy")
