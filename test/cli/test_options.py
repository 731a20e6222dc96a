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
import contextlib
import os
import re
from pathlib import Path

import pytest
from processes import scripted

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_excite_argument,
    add_limit_argument,
    add_mission_arguments,
    add_page_arguments,
    chosen_configuration,
    chosen_overrides,
    number,
)
from uav_tracking_mpc.cli.program import explained
from uav_tracking_mpc.cli.view import opened_page
from uav_tracking_mpc.view.serving import browser
from uav_tracking_mpc.view.serving.guarded_server import listen
from uav_tracking_mpc.view.watched_flight import FlightSource


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


@pytest.mark.parametrize(
    ("words", "signal"),
    [
        (["nmpc_controller.airspeed=30"], (0.044, 0.0807, 1.5)),
        (["nmpc_controller.excitation=[0.01,0,0]"], (0.01, 0.0, 0.0)),
    ],
    ids=["by the airspeed", "set"],
)
def test_the_excitation_is_that_of_the_airspeed_unless_it_is_set(words, signal):
    parser = argparse.ArgumentParser()
    add_configuration_arguments(parser)
    add_excite_argument(parser)
    arguments = parser.parse_args(["--config", "small_uav", "--excite", "--set", *words])
    assert chosen_configuration(arguments).controller.excitation == pytest.approx(signal, abs=1e-4)


def test_a_number_out_of_range_is_explained():
    convert = number(int, 1, 10)
    assert convert("10") == 10
    for text in ("0", "11", "1.5", "x"):
        with pytest.raises(argparse.ArgumentTypeError, match="is not an integer from 1 to 10"):
            convert(text)
    with pytest.raises(argparse.ArgumentTypeError, match="is not a number at least 0"):
        number(float, 0.0)("nan")


pytest.importorskip("viser")


class NoFlights(FlightSource):
    def __init__(self):
        self.closed = False

    def flights(self):
        return []

    def close(self):
        self.closed = True


def parsed_page_arguments(*words):
    parser = argparse.ArgumentParser()
    add_page_arguments(parser)
    return parser.parse_args(words)


@pytest.fixture
def windows(monkeypatch):
    """Addresses that would have been opened, on a machine with a screen."""
    opened = []
    monkeypatch.setattr(browser, "is_watched", lambda: True)

    def open_browser(address):
        opened.append(address)
        return contextlib.nullcontext()

    monkeypatch.setattr(browser, "open_browser", open_browser)
    return opened


def test_the_address_is_one_line_on_stderr_and_stdout_stays_clean():
    program = (
        "from test_options import NoFlights, parsed_page_arguments as parsed\n"
        "from uav_tracking_mpc.cli.view import opened_page\n"
        "with opened_page(NoFlights(), parsed('--port', '0', '--no-browser')) as page:\n"
        "    page.draw()\n"
    )
    room = Path(__file__).parent
    env = {**os.environ, "PYTHONPATH": f"{room}:{room.parent}"}
    code, output, errors = scripted(program, env=env)
    assert (code, output) == (0, ""), errors
    assert re.fullmatch(r"page: http://127\.0\.0\.1:\d+/\?token=[\w-]{32,}\n", errors)


def test_a_screen_gets_the_page_in_its_browser(windows):
    source = NoFlights()
    with opened_page(source, parsed_page_arguments("--port", "0")) as page:
        assert windows == [page.address]
    assert source.closed


def test_a_page_for_others_asks_for_a_token_that_only_the_address_tells(windows, capsys):
    with opened_page(
        NoFlights(), parsed_page_arguments("--port", "0", "--host", "127.0.0.1")
    ) as page:
        assert "/?token=" in page.address
        assert f"page: {page.address}\n" in capsys.readouterr().err
    with opened_page(NoFlights(), parsed_page_arguments("--port", "0", "--no-browser")):
        pass
    assert windows == []


def test_a_port_that_is_taken_is_one_line_and_exit_code_1(capsys):
    source = NoFlights()
    with listen(port=0) as taken:
        port = str(taken.getsockname()[1])
        with (
            explained("uav_tracking") as ending,
            opened_page(source, parsed_page_arguments("--port", port)),
        ):
            pass
    assert ending.code == 1
    assert capsys.readouterr().err == (
        f"uav_tracking: port {port} of 127.0.0.1 is taken: end what listens there, or choose a "
        "--port\n"
    )
    assert source.closed


def test_without_viser_the_command_says_what_to_install():
    program = "from uav_tracking_mpc.cli.main import main; sys.exit(main(['view', 'none.mcap']))"
    words = "uav_tracking: viser is not installed: `pip install 'uav_tracking_mpc[view]'`\n"
    assert scripted(program, missing=("viser",)) == (2, "", words)
