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

"""The README is short, and its links and commands are right."""

import re
from pathlib import Path

import pytest

from uav_tracking_mpc.cli.main import main

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text()


def test_it_is_short():
    assert len(TEXT.splitlines()) <= 150


def test_its_links_lead_somewhere():
    for link in re.findall(r"\]\(([^)#]+)\)", TEXT):
        assert "://" in link or (ROOT / link).exists(), link


def test_its_snippet_names_what_the_package_has():
    (names,) = re.findall(r"from uav_tracking_mpc import (.*)", TEXT)
    for name in names.split(", "):
        assert hasattr(__import__("uav_tracking_mpc"), name)


def test_its_commands_are_known(capsys):
    for command in set(re.findall(r"uav_tracking (\w+)", TEXT)):
        with pytest.raises(SystemExit) as ending:
            main([command, "--help"])
        assert ending.value.code == 0, command
        capsys.readouterr()


def test_its_ros_commands_have_their_arguments_behind_ros_args():
    for line in re.findall(r"ros2 run .*", TEXT):
        assert "params-file" not in line or "--ros-args --params-file" in line
