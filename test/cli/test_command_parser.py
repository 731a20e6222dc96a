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

"""Help shows every default; errors name what may have been meant and how the command is used."""

import argparse
import importlib

import pytest

from uav_tracking_mpc.cli import launch_tracking
from uav_tracking_mpc.cli.command_parser import CommandParser
from uav_tracking_mpc.cli.main import COMMANDS


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
