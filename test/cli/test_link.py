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

"""``uav_tracking link check``, and the options that choose a link."""

import argparse
import os
from pathlib import Path

import pytest
from processes import scripted

from uav_tracking_mpc.cli.options import add_link_arguments, place
from uav_tracking_mpc.settings.configuration import load_configuration

LINK = f"{Path(__file__).parents[1] / 'paced_link.py'}:PacedLink"


CHECK = ("link", "check", "--link", LINK)


def test_what_was_found_is_told(uav_tracking):
    out = uav_tracking.told(*CHECK)
    for words in (
        "firmware: paced 1.0",
        "wind: ",
        "envelope: bank_max is 0.7 by the vehicle, not 0.7854",
        "warning: no fence",
        "orbit: 300 m at 120 m and 22 m/s, nearest; it fits: bank up to 40 deg, airspeed 15.0 to "
        "32.0 m/s, not below 30 m",
    ):
        assert words in out


def test_the_same_as_one_object(uav_tracking):
    content = uav_tracking.json(*CHECK)
    assert content["found"] == {"firmware": "paced 1.0"}
    assert content["envelope"]["bank_max"] == 0.7
    assert content["warnings"] == ["no fence"]
    assert content["refusals"] == []
    assert len(content["wind_mps"]) == 3


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--connection", "nobody"], "nobody answers"),
        (["--connection", "copter"], "it is a copter"),
        (["--connection", "disarmed"], "disarmed"),
        (["--connection", "tight"], "needs a turn rate"),
        (["--set", "nmpc_controller.range=1"], "orbit range is 1.0 m"),
        (["--link", "nowhere.py:Link"], "there is no file"),
        (["--link", "balloon"], "parameter 'link' is 'balloon', must be one of ardupilot"),
        (["--link", "ardupilot", "--connection", "udpin:nowhere"], "must be udpin:HOST:PORT"),
        (["--link", "ardupilot", "--connection", "tcp:127.0.0.1:1"], "cannot be opened"),
        (["--link", "ardupilot", "--connection", "serial:/dev/nowhere:57600"], "/dev/nowhere"),
        (["--link", "ardupilot", "--signing-key", "/nowhere"], "signing key '/nowhere'"),
    ],
)
def test_what_cannot_be_flown_is_one_line_and_code_2(uav_tracking, arguments, words):
    ended = uav_tracking(*CHECK, "--timeout", 0.2, *arguments)
    assert ended.code == 2
    err = ended.err
    assert err.startswith("uav_tracking: ")
    assert words in err
    assert err.count("\n") == 1


def parsed(*words):
    parser = argparse.ArgumentParser()
    parser.add_argument("--set", dest="overrides", action="append", default=[])
    add_link_arguments(parser, flown=True)
    return parser.parse_args(words)


def test_options_are_short_forms_of_settings():
    arguments = parsed(
        *("--link", "ardupilot", "--connection", "udpin:0.0.0.0:14550", "--engage"),
        *("--origin=-33.9,18.4,40", "--target-system", "7", "--signing-key", "key"),
    )
    link = load_configuration("small_uav", arguments.overrides).link
    assert (link.link, link.connection, link.engage) == ("ardupilot", "udpin:0.0.0.0:14550", True)
    assert link.origin == (-33.9, 18.4, 40.0)
    assert (link.target_system, link.signing_key) == (7, "key")
    assert parsed().overrides == []


@pytest.mark.parametrize("text", ["", "47", "47,8", "91,0,0", "a,b,c", "nan,0,0", "0,0,1e9"])
def test_what_is_no_place_is_refused(text):
    with pytest.raises(argparse.ArgumentTypeError, match="is not LAT,LON,ALT"):
        place(text)
    assert place("47.4,8.5,488") == (47.4, 8.5, 488.0)


def test_an_autopilot_is_looked_at_without_ros():
    program = f"from uav_tracking_mpc.cli.main import main; sys.exit(main({CHECK}))"
    finding = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[1])}
    code, output, errors = scripted(program, missing=("rclpy",), env=finding)
    assert code == 0, errors
    assert "it fits" in output
