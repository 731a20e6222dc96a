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

"""A flight with a page: the same flight, and a page that it does not depend on."""

import json
import os
import re
import subprocess
import urllib.request

import pytest
from processes import DOMAIN, INTERRUPT, KILL, alive, command, environment, wait_for

from uav_tracking_mpc.cli.main import main

LIMIT = 240.0  # s; for what is broken, not a measure of what works


@pytest.mark.parametrize("words", [("--port", "0"), ("--host", "0.0.0.0"), ("--no-browser",)])
def test_options_of_a_page_need_one(words, tmp_path, uav_tracking):
    refusal = uav_tracking.refused("fly", *words, "--output", tmp_path)
    assert f"{words[0]} needs --view" in refusal


def test_what_does_not_fly_leaves_the_last_flight_as_it_is(tmp_path, monkeypatch, uav_tracking):
    last = {name: f"the last {name}" for name in ("mission.mcap", "controller.jsonl")}
    for name, content in last.items():
        (tmp_path / name).write_text(content)
    monkeypatch.setenv("ROS_DOMAIN_ID", "far")
    assert "ROS_DOMAIN_ID is 'far'" in uav_tracking.refused("fly", "--output", tmp_path)
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == last


@pytest.mark.nodes
def test_security_without_keys_is_refused_in_words(tmp_path, monkeypatch, capfd):
    (tmp_path / "keys" / "enclaves").mkdir(parents=True)
    monkeypatch.setenv("ROS_SECURITY_ENABLE", "true")
    monkeypatch.setenv("ROS_SECURITY_STRATEGY", "Enforce")
    monkeypatch.setenv("ROS_SECURITY_KEYSTORE", str(tmp_path / "keys"))
    output = tmp_path / "output"
    assert main(["fly", "--output", str(output)]) == 2
    assert "which needs ROS_SECURITY_KEYSTORE" in capfd.readouterr().err
    assert not list(output.iterdir())


class ViewedFlight:
    """``uav_tracking fly --view`` as a process."""

    def __init__(self, folder):
        self.folder = folder
        self.log = (folder / "log").open("w")
        words = ("--view", "--no-browser", "--port", "0", "--duration", "20", "--output", folder)
        self.process = subprocess.Popen(
            command("cli.main", "fly", *words, "--domain-id", DOMAIN),
            stdout=subprocess.DEVNULL,
            stderr=self.log,
            env=environment(),
        )

    def words(self):
        return (self.folder / "log").read_text()

    def address(self):
        assert wait_for(lambda: "page: http" in self.words(), LIMIT), self.words()
        return re.search(r"page: (http://127\.0\.0\.1:\d+\S*)", self.words())[1]

    def page(self):
        """Process id of the page."""
        children = subprocess.run(
            ["ps", "-ww", "-o", "pid=,args=", "--ppid", str(self.process.pid)],
            capture_output=True,
            text=True,
        ).stdout
        (line,) = [line for line in children.splitlines() if " view --domain-id " in line]
        return int(line.split()[0])

    def end(self):
        self.log.close()
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()


@pytest.fixture
def flight(tmp_path):
    flight = ViewedFlight(tmp_path)
    yield flight
    flight.end()


def answers(address):
    with urllib.request.urlopen(address, timeout=60.0) as response:
        return response.status == 200


@pytest.mark.nodes
@pytest.mark.timeout(900)
def test_the_page_stays_after_the_report_until_ctrl_c(flight):
    pytest.importorskip("viser")
    address = flight.address()
    page = flight.page()
    assert answers(address)
    assert wait_for(lambda: "until Ctrl-C" in flight.words(), LIMIT), flight.words()
    metrics = json.loads((flight.folder / "metrics.json").read_text())
    assert metrics["duration_s"] == pytest.approx(20.0, abs=1.0)
    assert answers(address)
    flight.process.send_signal(INTERRUPT)
    code = flight.process.wait(LIMIT)
    assert code == (3 if "not settled" in flight.words() else 0)  # of the flight, not of Ctrl-C
    assert not alive(page)
    assert "Traceback" not in flight.words()


@pytest.mark.nodes
@pytest.mark.timeout(900)
def test_a_page_that_dies_ends_no_flight(flight):
    pytest.importorskip("viser")
    flight.address()
    os.kill(flight.page(), KILL)
    code = flight.process.wait(LIMIT)
    assert code == (3 if "not settled" in flight.words() else 0), flight.words()
    assert (flight.folder / "report.html").exists()
