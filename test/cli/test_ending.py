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

"""Errors that a command expects become one line and an exit code."""

import pytest

from uav_tracking_mpc.cli.ending import explained
from uav_tracking_mpc.launch.flight import FlightInterruptedError
from uav_tracking_mpc.launch.supervisor import LaunchError
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.simulation.closed_loop import SimulationError


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (ParameterError("no such orbit"), 2, "no such orbit"),
        (ExtensionError("there is no law"), 2, "there is no law"),
        (LinkError("no autopilot answers"), 2, "no autopilot answers"),
        (LaunchError("a node died"), 1, "a node died"),
        (SimulationError("no value there"), 1, "no value there"),
        (PermissionError(13, "not allowed", "/x"), 1, "/x"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (FlightInterruptedError(15), 143, "interrupted before the first command"),
        (FlightInterruptedError(2, link=True), 130, "before the autopilot was engaged"),
        (ModuleNotFoundError("rclpy", name="rclpy"), 2, "source its setup file"),
        (
            ModuleNotFoundError(name="nav_msgs.msg"),
            2,
            "nav_msgs is not installed; flying needs ROS",
        ),
        (ModuleNotFoundError(name="pyarrow.parquet"), 2, "uav_tracking_mpc[campaign]"),
        (ModuleNotFoundError(name="viser.transforms"), 2, "uav_tracking_mpc[view]"),
        (ModuleNotFoundError(name="rich.console"), 2, "`pip install uav_tracking_mpc` brings it"),
        (ImportError("the proof needs python-flint"), 2, "python-flint"),
    ],
)
def test_one_line_and_an_exit_code(error, code, words, capsys):
    with explained("program") as ending:
        raise error
    assert ending.code == code
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("program: ")
    assert words in said.err
    assert said.err.count("\n") == 1


@pytest.mark.parametrize(
    "error", [ZeroDivisionError(), ModuleNotFoundError(name="uav_tracking_mpc.nowhere")]
)
def test_a_mistake_in_the_program_is_not_hidden(error):
    with pytest.raises(type(error)), explained("program"):
        raise error


def test_without_an_error_the_code_is_the_commands(capsys):
    with explained("program") as ending:
        ending.code = 1
    assert ending.code == 1
    assert capsys.readouterr().err == ""
