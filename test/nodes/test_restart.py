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

"""The controller is killed in mid-turn: the vehicle goes on, and a new one is soon in command."""

import os
import subprocess
import time

import numpy as np
import pytest
from node_flight import ON_ORBIT
from node_harness import Nodes
from processes import DOMAIN, KILL, PATIENCE, TERMINATE, command, environment

from uav_tracking_mpc.nodes.messages.conversions import (
    measurement_from_odometry,
    plan_from_command,
    position_from_point,
)
from uav_tracking_mpc.nodes.topics import COMMAND, DIAGNOSTICS, ODOMETRY, TARGET
from uav_tracking_mpc.settings.configuration import load_configuration

pytestmark = [pytest.mark.nodes, pytest.mark.alone]

LOADED = 3.0  # s of wall time from the start of the process until it is configured
# s more to its first command: participants that miss each other's first announcements meet at the
# next ones, which Fast DDS sends every 3 s. Mostly it is less than one.
DISCOVERY = 3.5
BACK = 30.0  # s to the orbit


def waited(process):
    """Time in [s] that a process was ready to run and the machine busy with others."""
    total = 0
    for task in os.scandir(f"/proc/{process}/task"):
        with open(f"{task.path}/schedstat", encoding="ascii") as file:
            total = max(total, int(file.read().split()[1]))
    return total * 1e-9


class Processes(Nodes):
    """The nodes as processes in real time, and somebody who listens in this one."""

    def __init__(self, folder):
        super().__init__(domain_id=int(DOMAIN))
        configuration = load_configuration("small_uav", ON_ORBIT)
        self.parameters = configuration.controller
        self.file, self.log = folder / "parameters.yaml", folder / "nodes.log"
        self.file.write_text(configuration.yaml())
        self.heard = self.listen(COMMAND, ODOMETRY, TARGET, DIAGNOSTICS)
        self.commands, self.processes = self.heard[COMMAND.name], {}

    def start(self, name, *assignments):
        arguments = [word for each in assignments for word in ("-p", each)]
        with self.log.open("a") as log:
            self.processes[name] = subprocess.Popen(
                command(f"nodes.{name}", "--ros-args", "--params-file", self.file, *arguments),
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment(),
            )
        return self.processes[name]

    def kill(self, name):
        process = self.processes.pop(name)
        process.send_signal(KILL)
        process.wait()

    @property
    def flown(self):
        """The latest state."""
        return measurement_from_odometry(self.heard[ODOMETRY.name][-1])

    @property
    def holding(self):
        """Whether the simulator says that it holds."""
        said = [s for message in self.heard[DIAGNOSTICS.name] for s in message.status]
        words = [status.message for status in said if "uav_simulator" in status.name]
        return "holding wings level" in words[-1]

    def error(self):
        offset = self.flown.position - position_from_point(self.heard[TARGET.name][-1])
        orbit = self.parameters.orbit
        return max(abs(np.linalg.norm(offset) - orbit.range), abs(offset[2] - orbit.altitude))

    def restart(self):
        """Start a new controller; how far its first command is from what is flown."""
        self.commands.clear()
        begin, before = time.monotonic(), len(self.log.read_text())
        process = self.start("nmpc_controller")
        assert self.spin(lambda: "orbit of 300 m" in self.log.read_text()[before:])
        loaded = time.monotonic() - begin - waited(process.pid)
        assert loaded < LOADED
        assert self.spin(lambda: self.commands, DISCOVERY)
        plan = plan_from_command(self.commands[0])[0]
        upper, lower = self.parameters.input_upper, self.parameters.input_lower
        assert np.all(plan <= upper + 1e-9)
        assert np.all(plan >= lower - 1e-9)
        assert np.all(np.abs(plan[:, 0]) <= self.parameters.envelope.turn_rate_max(21.0))
        flown = self.flown
        return np.abs(plan[0, :2] - [flown.turn_rate, flown.path_angle_rate])

    def end(self):
        for process in self.processes.values():
            process.send_signal(TERMINATE)
        for process in self.processes.values():
            process.wait(PATIENCE)
        super().end()


@pytest.fixture
def nodes(tmp_path):
    nodes = Processes(tmp_path)
    yield nodes
    nodes.end()


def test_a_controller_killed_in_mid_turn_is_soon_replaced(nodes):
    nodes.start("nmpc_controller")
    nodes.start("target_publisher")
    nodes.start("uav_simulator", "start_on_command:=true", "wait_for_subscribers:=1")
    assert nodes.spin(lambda: len(nodes.commands) > 60)
    assert abs(nodes.flown.turn_rate) > 0.05

    # At once: the vehicle still flies the plan of the one that is gone.
    nodes.kill("nmpc_controller")
    step = nodes.restart()
    assert not nodes.holding
    assert abs(nodes.flown.turn_rate) > 0.05
    envelope = nodes.parameters.envelope
    assert step[0] < 0.5 * envelope.turn_rate_max(22.0)
    assert nodes.error() < 10.0

    # Late: the plan is flown to its end, then the wings are level.
    assert nodes.spin(lambda: len(nodes.commands) > 60)
    nodes.kill("nmpc_controller")
    plan_length = nodes.parameters.horizon * nodes.parameters.horizon_step
    killed = time.monotonic()
    assert nodes.spin(lambda: nodes.holding, plan_length + 5.0)
    assert time.monotonic() - killed > plan_length - 2.0
    assert nodes.spin(lambda: abs(nodes.flown.turn_rate) < 0.01, 5.0)
    nodes.spin(lambda: False, 5.0)  # a hundred metres and more along the tangent
    nodes.restart()
    assert nodes.error() > 10.0
    assert nodes.spin(lambda: nodes.error() < 10.0, BACK)
