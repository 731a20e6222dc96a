"""Options that commands share, and the configuration that they choose."""

import argparse

import pytest

from uav_tracking_mpc.cli.arguments import (
    HelpFormatter,
    add_configuration_arguments,
    add_limit_argument,
    add_mission_arguments,
    chosen_configuration,
    chosen_overrides,
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


def test_help_shows_defaults_where_there_are_any():
    parser = argparse.ArgumentParser(formatter_class=HelpFormatter)
    parser.add_argument("--count", default=3, help="how many")
    parser.add_argument("--file", help="which")
    parser.add_argument("--fast", action="store_true", help="hurry")
    text = parser.format_help()
    assert "how many (default: 3)" in text
    assert text.count("default") == 1
