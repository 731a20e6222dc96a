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

"""The service that kills the controller, on a process that needs no ROS."""

from types import SimpleNamespace

import pytest
from processes import alive
from rich.console import Console
from std_srvs.srv import Trigger

from uav_tracking_mpc.launch.controller_kill import ControllerKill
from uav_tracking_mpc.launch.supervisor import Supervisor

SERVER = ("http.server", ["0", "--bind", "127.0.0.1"])  # runs until it is ended


@pytest.fixture
def supervisor(tmp_path):
    with (tmp_path / "output").open("w") as file:
        supervisor = Supervisor(tmp_path, Console(file=file), domain=7)
        for name in ("nmpc_controller", "uav_simulator"):
            supervisor.start(name, *SERVER)
        yield supervisor
        supervisor.end()


def test_the_controller_alone_is_killed_and_runs_again(supervisor):
    services = {}
    node = SimpleNamespace(create_service=lambda kind, name, call: services.update({name: call}))
    kill = ControllerKill(node, supervisor)
    before = {name: process.identity for name, process in supervisor.processes.items()}
    kill.follow()
    assert supervisor.processes["nmpc_controller"].identity == before["nmpc_controller"]
    answer = services["nmpc_controller/kill"](Trigger.Request(), Trigger.Response())
    assert (answer.success, answer.message) == (True, "nmpc_controller is killed and started again")
    assert alive(before["nmpc_controller"])  # the callback itself waits for no process
    kill.follow()
    assert not alive(before["nmpc_controller"])
    again = supervisor.processes["nmpc_controller"].identity
    assert again != before["nmpc_controller"] and alive(again)
    assert supervisor.processes["uav_simulator"].identity == before["uav_simulator"]
    supervisor.check()  # nobody misses the one that was killed
    kill.follow()
    assert supervisor.processes["nmpc_controller"].identity == again
