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

"""How a page starts: its address on stderr, nothing on stdout, a taken port in words."""

import argparse
import contextlib
import re
import subprocess
import sys

import pytest

from uav_tracking_mpc.cli.ending import explained
from uav_tracking_mpc.cli.page_arguments import add_page_arguments, opened_page
from uav_tracking_mpc.view.serving import browser
from uav_tracking_mpc.view.serving.listening import listen
from uav_tracking_mpc.view.watched_flight import FlightSource

pytest.importorskip("viser")


class NoFlights(FlightSource):
    def __init__(self):
        self.closed = False

    def flights(self):
        return []

    def close(self):
        self.closed = True


def parsed(*words):
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
        "from test_page_arguments import NoFlights, parsed\n"
        "from uav_tracking_mpc.cli.page_arguments import opened_page\n"
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
    with opened_page(source, parsed("--port", "0")) as page:
        assert windows == [page.address]
    assert source.closed


def test_a_page_for_others_asks_for_a_token_that_only_the_address_tells(windows, capsys):
    with opened_page(NoFlights(), parsed("--port", "0", "--host", "127.0.0.1")) as page:
        assert "/?token=" in page.address
        assert f"page: {page.address}\n" in capsys.readouterr().err
    with opened_page(NoFlights(), parsed("--port", "0", "--no-browser")):
        pass
    assert windows == []


def test_a_port_that_is_taken_is_one_line_and_exit_code_1(capsys):
    source = NoFlights()
    with listen(port=0) as taken:
        port = str(taken.getsockname()[1])
        with explained("uav_tracking") as ending, opened_page(source, parsed("--port", port)):
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
        parsed("--port", port)
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
