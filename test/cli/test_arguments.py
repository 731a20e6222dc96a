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

"""Options that commands share, and the configuration that they choose."""

import argparse
from pathlib import Path

import pytest

from uav_tracking_mpc.cli.arguments import (
    add_configuration_arguments,
    add_domain_argument,
    add_limit_argument,
    add_mission_arguments,
    chosen_configuration,
    chosen_overrides,
    existing_file,
    number,
)
from uav_tracking_mpc.parameters.specification import ParameterError


def parsed(*words):
    parser = argparse.ArgumentParser()
    add_mission_arguments(parser, plant="mission.plant")
    return parser.parse_args(words)


def test_options_are_short_forms_of_set_and_the_last_wins():
    both = parsed("--duration", "30", "--set", "mission.duration=40", "--plant", "euler")
    configuration = chosen_configuration(both)
    assert configuration.mission.duration == 40.0
    assert configuration.mission.plant == "euler"
    assert parsed("--law", "l1").overrides == ['nmpc_controller.law="l1"']


def test_limits_are_added_to_those_of_the_configuration():
    parser = argparse.ArgumentParser()
    add_configuration_arguments(parser)
    add_limit_argument(parser)
    words = ["--set", "nmpc_controller.limits=height", "--limit", "fence", "--limit", "bank"]
    chosen = parser.parse_args(words)
    assert chosen_configuration(chosen).controller.limits == "height,fence,bank"
    assert chosen_overrides(chosen)[-1] == 'nmpc_controller.limits="height,fence,bank"'


def test_parameters_of_an_added_limit_can_be_set():
    example = Path(__file__).parents[2] / "examples" / "add_a_limit.py"
    parser = argparse.ArgumentParser()
    add_configuration_arguments(parser)
    add_limit_argument(parser)
    words = ["--set", "nmpc_controller.cylinder_radius=40", "--limit", f"{example}:NoFlyCylinder"]
    chosen = chosen_configuration(parser.parse_args(words)).controller
    assert chosen.envelope.cylinder_radius == 40.0


def test_what_does_not_exist_is_refused():
    with pytest.raises(ParameterError, match="glider"):
        chosen_configuration(parsed("--plant", "glider"))


def test_a_number_out_of_range_is_explained():
    convert = number(int, 1, 10)
    assert convert("10") == 10
    for text in ("0", "11", "1.5", "x"):
        with pytest.raises(argparse.ArgumentTypeError, match="is not an integer from 1 to 10"):
            convert(text)
    with pytest.raises(argparse.ArgumentTypeError, match="is not a number at least 0"):
        number(float, 0.0)("nan")


def test_the_allowed_range_is_said_where_a_number_is_none(capsys):
    for words in (["--duration", "long"], ["--domain-id", "300"]):
        parser = argparse.ArgumentParser()
        add_mission_arguments(parser, plant="mission.plant")
        add_domain_argument(parser, "where")
        with pytest.raises(SystemExit):
            parser.parse_args(words)
    said = capsys.readouterr().err
    assert "'long' is not a number from 1 to 1e+06 s" in said
    assert "'300' is not an integer from 0 to 232" in said


def test_a_parameter_without_effect_has_no_option():
    parser = argparse.ArgumentParser()
    add_mission_arguments(parser, plant="mission.plant", without=["speed"])
    assert "--speed" not in parser.format_help()
    assert "--duration" in parser.format_help()


def test_a_file_that_must_be_there(tmp_path):
    file = tmp_path / "page.md"
    with pytest.raises(argparse.ArgumentTypeError, match="there is no file"):
        existing_file(str(file))
    file.write_text("")
    assert existing_file(str(file)) == file
