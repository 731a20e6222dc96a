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

"""The supervisor, on processes that need no ROS."""

import os
import sys
from pathlib import Path

import pytest
from processes import alive, wait_for
from rich.console import Console

from uav_tracking_mpc.launch.supervisor import LaunchError, Supervisor, supervised

SERVER = ("http.server", ["0", "--bind", "127.0.0.1"])  # runs until it is ended


@pytest.fixture
def output(tmp_path):
    with (tmp_path / "output").open("w+") as file:
        yield file


@pytest.fixture
def supervisor(tmp_path, output):
    supervisor = Supervisor(tmp_path, Console(file=output), domain=7)
    yield supervisor
    supervisor.end()


def state(identity):
    return Path(f"/proc/{identity}/stat").read_text().split()[2]


def test_a_process_that_ends_is_named_with_its_exit_code(supervisor, output):
    supervisor.start("no_module", "no_such_module")
    assert wait_for(supervisor.dead)
    assert supervisor.dead() == {"no_module": 1}
    with pytest.raises(LaunchError, match="no_module died with exit code 1"):
        supervisor.check()
    supervisor.end()
    output.seek(0)
    assert "[no_module] " in output.read()


def test_a_killed_process_is_not_missed_and_starts_again(supervisor):
    supervisor.start("server", *SERVER)
    first = supervisor.processes["server"]
    supervisor.kill("server")
    assert not alive(first.identity)
    assert supervisor.dead() == {}
    supervisor.restart("server")
    second = supervisor.processes["server"]
    assert alive(second.identity)
    assert second.identity != first.identity
    assert second.started > first.started


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_a_frozen_process_goes_on_or_is_ended(supervisor):
    supervisor.start("server", *SERVER)
    identity = supervisor.processes["server"].identity
    supervisor.freeze("server")
    assert wait_for(lambda: state(identity) == "T")
    supervisor.thaw("server")
    assert wait_for(lambda: state(identity) != "T")
    supervisor.freeze("server")
    told = []
    supervisor.end(lambda: told.append(len(supervisor.processes)))
    assert told == [1]
    assert not alive(identity)


def test_a_domain_that_could_not_be_joined_is_left(output, monkeypatch):
    rclpy = pytest.importorskip("rclpy")

    def refuse(**options):
        raise RuntimeError("no room")

    monkeypatch.setattr(rclpy, "init", refuse)
    monkeypatch.setenv("ROS_DOMAIN_ID", "3")
    with pytest.raises(RuntimeError, match="no room"), supervised(Console(file=output), domain=7):
        pass
    assert os.environ["ROS_DOMAIN_ID"] == "3"
