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
import re
import urllib.request

import pytest
from processes import DOMAIN, INTERRUPT, alive, children_of, hear, started

from uav_tracking_mpc.cli.main import main

LIMIT = 900.0  # s; for what is broken, not a measure of what works


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


def answers(address):
    with urllib.request.urlopen(address, timeout=60.0) as response:
        return response.status == 200


@pytest.mark.nodes
def test_the_page_stays_after_the_report_until_ctrl_c(tmp_path):
    pytest.importorskip("viser")
    words = ("--view", "--no-browser", "--port", 0, "--duration", 4)
    where = ("--output", tmp_path, "--domain-id", DOMAIN)
    how = {"after": "page: http", "apart": True}
    with started("cli.main", "fly", *words, *where, **how) as flight:
        children = children_of(flight.pid)
        (page,) = (child for child, words in children if " view --domain-id " in words)
        address = re.search(r"page: (http://127\.0\.0\.1:\d+\S*)", flight.said)[1]
        assert answers(address)
        hear(flight, "until Ctrl-C")
        assert (tmp_path / "metrics.json").is_file(), flight.said
        metrics = json.loads((tmp_path / "metrics.json").read_text())
        assert 0.0 < metrics["duration_s"] < 5.0  # a slow machine hears the first states late
        assert answers(address)
        flight.send_signal(INTERRUPT)
        _, rest = flight.communicate(timeout=LIMIT)
        assert flight.returncode == 3, rest  # that of a flight that is too short, not of Ctrl-C
        assert "Traceback" not in flight.said + rest
        assert not alive(page)
