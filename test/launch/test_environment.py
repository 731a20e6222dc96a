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

"""What the launcher takes from the environment, with real nodes."""

from __future__ import annotations

import subprocess

import pytest
from processes import DOMAIN, TERMINATE, command, environment

from uav_tracking_mpc.launch.domain import own_domain

pytestmark = pytest.mark.nodes


def until(words, *arguments, **exported):
    """Output of ``launch_tracking`` up to a line with these words, or its end; and exit code."""
    process = subprocess.Popen(
        command("cli.launch_tracking", *arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env={**environment(), **exported},
    )
    assert process.stdout is not None
    said = []
    for line in process.stdout:
        said.append(line)
        if words in line:
            process.send_signal(TERMINATE)
            break
    rest = process.communicate(timeout=60)[0]
    return "".join(said) + rest, process.returncode


def test_an_exported_domain_is_flown_in_and_an_option_wins():
    output, code = until("domain")
    assert output.startswith(f"domain {DOMAIN} (from ROS_DOMAIN_ID): watch with")
    assert code == 0, output
    with own_domain(None) as other:
        output, _ = until("domain", "--domain-id", str(other))
    assert output.startswith(f"domain {other}: watch with")


def test_a_domain_that_is_not_allowed_is_refused():
    output, code = until("never said", ROS_DOMAIN_ID="300")
    assert code == 2
    assert output == (
        "launch_tracking: environment variable ROS_DOMAIN_ID is '300', must be an integer from 0 "
        "to 232\n"
    )


def test_without_a_home_and_with_an_empty_cache_it_flies_at_once(tmp_path):
    nowhere = tmp_path / "file"
    nowhere.write_text("")
    output, code = until(
        "flying on commands",
        HOME=str(nowhere),
        ROS_LOG_DIR="",
        ROS_HOME="",
        XDG_CACHE_HOME=str(nowhere),
        TMPDIR=str(tmp_path),
    )
    assert code == 0, output
    assert "Traceback" not in output
    assert "/.ros/log cannot be written" in output
    begin, flying = (output.index(words) for words in ("ipopt solves while", "flying on commands"))
    assert begin < flying
    assert "solver compiled" not in output[:flying]
