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

import argparse
import importlib
import json
from unittest import mock

import pytest

from uav_tracking_mpc.cli import launch_tracking
from uav_tracking_mpc.cli.main import COMMANDS
from uav_tracking_mpc.cli.program import CommandParser, answer, check_writable, explained
from uav_tracking_mpc.launch.flight import FlightInterruptedError
from uav_tracking_mpc.launch.supervisor import LaunchError
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.parameters.registry import ExtensionError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.report.pages import Table
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
        (
            ModuleNotFoundError(name="pyarrow.parquet"),
            2,
            "pyarrow is not installed: `pip install 'uav_tracking_mpc[campaign]'`",
        ),
        (ModuleNotFoundError(name="viser.transforms"), 2, "uav_tracking_mpc[view]"),
        (ModuleNotFoundError(name="rich.console"), 2, "`pip install uav_tracking_mpc` brings it"),
        (ImportError("the page needs viser"), 2, "viser"),
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


def test_json_is_all_that_is_printed(capsys):
    answer({"range_m": 1.5, "name": "x"}, ["words"], as_json=True)
    assert json.loads(capsys.readouterr().out) == {"range_m": 1.5, "name": "x"}


def test_json_knows_no_nan():
    with pytest.raises(ValueError, match="JSON"):
        answer({"range_m": float("nan")}, [], as_json=True)


def test_a_table_is_never_cut_off(capsys):
    headings = [f"a long heading {n}" for n in range(20)]
    table = Table(headings, [[f"cell number {n}" for n in range(20)]])
    answer({}, ["[before]", table], as_json=False)
    text = capsys.readouterr().out
    assert text.startswith("[before]\n")
    assert all(f"cell number {n}" in text for n in range(20))


def commands():
    """Every command and action with its options."""
    for name in COMMANDS:
        module = importlib.import_module(f"uav_tracking_mpc.cli.{name}")
        parser = CommandParser(prog=name, description=module.DESCRIPTION)
        module.add_arguments(parser)
        yield parser
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                yield from action.choices.values()
    yield launch_tracking._parser()


@pytest.mark.parametrize("parser", list(commands()), ids=lambda parser: parser.prog)
def test_every_command_describes_itself_and_every_default(parser):
    assert parser.description
    text = " ".join(parser.format_help().split())
    assert "(default: )" not in text
    for action in parser._actions:
        assert action.help, action
        if action.option_strings and action.nargs != 0 and action.default != []:
            # argparse asks for the words of an action right where it writes them.
            words = parser._get_formatter()._get_help_string(action)
            assert "default" in words, action


def test_a_default_of_zero_and_a_list_are_shown():
    parser = CommandParser()
    parser.add_argument("--seed", default=0, help="of the states")
    parser.add_argument("--laws", nargs="+", default=["nmpc", "l1"], help="that fly")
    parser.add_argument("--file", help="which")
    parser.add_argument("--key", default="", help="to sign with")
    parser.add_argument("--more", action="append", default=[], help="may be repeated")
    parser.add_argument("--fast", action="store_true", help="hurry")
    text = parser.format_help()
    assert "of the states (default: 0)" in text
    assert "that fly (default: nmpc l1)" in text
    assert text.count("(default: none)") == 2
    assert text.count("default") == 4


def refused(parser, *words):
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(words)
    assert ended.value.code == 2


def test_an_unknown_option_is_refused_by_its_own_command(capsys):
    parser = CommandParser(prog="uav")
    command = parser.add_subparsers(dest="command").add_parser("fly")
    command.add_argument("--duration", type=float)
    refused(parser, "fly", "--durration", "5")
    said = capsys.readouterr().err
    assert "uav fly: error: unrecognized arguments: --durration 5" in said
    assert said.rstrip().endswith("(did you mean '--duration'?)")
    assert "usage: uav fly" in said


def test_a_mistyped_command_or_choice_is_suggested(capsys):
    parser = CommandParser(prog="uav")
    commands = parser.add_subparsers(dest="command")
    commands.add_parser("simulate").add_argument("--law", choices=["npfg", "l1"])
    refused(parser, "simulat")
    assert "(did you mean 'simulate'?)" in capsys.readouterr().err
    refused(parser, "simulate", "--law", "nfpg")
    assert "(did you mean 'npfg'?)" in capsys.readouterr().err


def test_a_folder_that_can_be_written_stays_as_it_was(tmp_path):
    check_writable(tmp_path)
    check_writable(tmp_path / "new" / "deep")
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_its_place_and_a_folder_that_cannot_be_made_are_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(ParameterError, match="must be a folder that can be written: it is a file"):
        check_writable(file)
    for folder in (file / "below", "/proc/nowhere"):
        with pytest.raises(ParameterError, match="must be a folder that can be written"):
            check_writable(tmp_path / folder)
    with (
        mock.patch("tempfile.TemporaryFile", side_effect=OSError(28, "No space left on device")),
        pytest.raises(ParameterError, match="No space left on device"),
    ):
        check_writable(tmp_path / "new")
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate"],
        ["fly"],
        ["compare"],
        ["campaign", "robustness"],
        ["margins"],
        ["identify", "--validate", "1"],
        ["stability"],
        ["benchmark"],
        ["torture"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_every_command_looks_before_it_works(arguments, tmp_path, uav_tracking):
    file = tmp_path / "file"
    file.write_text("")
    refusal = uav_tracking.refused(*arguments, "--output", file)
    assert "must be a folder that can be written: it is a file" in refusal
    assert "simulating" not in refusal
