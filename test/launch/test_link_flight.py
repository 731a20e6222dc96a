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

"""Flights through a vehicle link with real processes, as a user flies them."""

import json
import subprocess
from pathlib import Path

import pytest
from processes import INTERRUPT, command, environment

from uav_tracking_mpc.nodes.flight_bag import messages
from uav_tracking_mpc.nodes.topics import COMMAND, ENGAGED, ORBIT

pytestmark = pytest.mark.nodes

LINK = f"{Path(__file__).parents[1] / 'paced_link.py'}:PacedLink"
FLY = ("fly", "--config", "small_uav", "--json", "--link")


def fly(output, *arguments):
    words = command("cli.main", *FLY, *arguments, "--output", output)
    env = environment() | {"PYTHONPATH": str(Path(__file__).parents[1])}
    return subprocess.run(words, capture_output=True, text=True, env=env, timeout=300)


@pytest.mark.parametrize("link", [(LINK,), ("ardupilot", "--simulated")], ids=["own", "ardupilot"])
def test_a_flight_counts_from_when_it_is_engaged_and_tells_of_its_link(tmp_path, link):
    flown = fly(tmp_path, *link, "--engage", "--duration", "4")
    assert flown.returncode == 3, flown.stderr  # 4 s are not enough
    assert flown.stderr.splitlines()[-1].startswith("not settled in ")
    numbers = json.loads(flown.stdout)
    assert numbers["duration_s"] == pytest.approx(4.0, abs=1.5)
    assert numbers["speed"] == 1.0
    keys = {"dialect", "rate_hz", "latency_ms", "latency_p99_ms", "lost", "refused"}
    assert numbers["link"].keys() == keys
    assert numbers["link"]["rate_hz"] > 5.0
    assert numbers["solver"]["solves"] > 10
    assert "engaged" in flown.stderr
    assert "Traceback" not in flown.stderr
    counts = {topic.name: 0 for topic in (COMMAND, ORBIT, ENGAGED)}
    for topic, _, _ in messages(tmp_path / "mission.mcap", COMMAND, ORBIT, ENGAGED):
        counts[topic.name] += 1
    assert counts[ORBIT.name] > 0.5 * counts[COMMAND.name] > 5


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((LINK, "--connection", "tight"), "needs a turn rate"),
        (("ardupilot", "--connection", "udpin:nowhere"), "must be udpin:HOST:PORT"),
    ],
)
def test_what_cannot_be_flown_starts_nothing(tmp_path, arguments, words):
    refused = fly(tmp_path, *arguments)
    assert refused.returncode == 2
    assert words in refused.stderr.splitlines()[-1]
    assert "domain" not in refused.stderr
    assert refused.stdout == ""
    assert not list(tmp_path.iterdir())


def test_without_engage_nothing_is_commanded_and_it_says_how(tmp_path):
    env = environment() | {"PYTHONPATH": str(Path(__file__).parents[1])}
    process = subprocess.Popen(
        command("cli.main", *FLY, LINK, "--output", tmp_path),
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=env,
    )
    told = ""
    for line in process.stderr:
        told += line
        if "tracking: optimal plan" in line:
            break
    process.send_signal(INTERRUPT)
    output, rest = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "until somebody engages: `uav_tracking engage --domain-id" in told
    assert "interrupted before the autopilot was engaged" in rest
    assert output == ""
    assert not (tmp_path / "mission.mcap").exists()
