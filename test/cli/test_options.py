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
import re
import subprocess
import sys
from pathlib import Path

import pytest

from uav_tracking_mpc.cli.options import (
    add_configuration_arguments,
    add_domain_argument,
    add_limit_argument,
    add_mission_arguments,
    add_page_arguments,
    chosen_configuration,
    chosen_overrides,
    existing_file,
    number,
)
from uav_tracking_mpc.cli.program import explained
from uav_tracking_mpc.cli.view import opened_page
from uav_tracking_mpc.parameters.specification import ParameterError
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
    script = (
        "import sys\n"
        "from test_options import NoFlights, parsed_page_arguments as parsed\n"
        "from uav_tracking_mpc.cli.view import opened_page\n"
        "with opened_page(NoFlights(), parsed('--port', '0', '--no-browser')) as page:\n"
        "    page.draw()\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script],
        cwd=__file__.rpartition("/")[0],
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
    )
    assert done.stdout == ""
    (line,) = done.stderr.splitlines()
    assert re.fullmatch(r"page: http://127\.0\.0\.1:\d+/\?token=[\w-]{32,}", line)


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


@pytest.mark.parametrize("port", ["-1", "65536", "http"])
def test_ports_are_numbers_that_exist(port, capsys):
    with pytest.raises(SystemExit):
        parsed_page_arguments("--port", port)
    assert "is not an integer from 0 to 65535" in capsys.readouterr().err


def test_without_viser_the_command_says_what_to_install(tmp_path):
    """Before anything else: a flight that nobody can see must not begin."""
    script = (
        "import sys\n"
        "sys.modules['viser'] = None\n"
        "from uav_tracking_mpc.cli.main import main\n"
        f"sys.exit(main(['view', {str(tmp_path / 'none.mcap')!r}]))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=100
    )
    assert done.returncode == 2
    assert done.stderr == (
        "uav_tracking: viser is not installed: `pip install 'uav_tracking_mpc[view]'`\n"
    )
