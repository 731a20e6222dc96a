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

"""Whether a late answer is the sender's or the own solve's, and one status while one compiles."""

import time
from unittest import mock

import numpy as np
import pytest

pytest.importorskip("rclpy")

import rclpy
from controller_flight import CONFIGURATION
from node_harness import NodeHarness, start_ros

from uav_tracking_mpc.mpc import bridged_solver
from uav_tracking_mpc.mpc.compilation import CompilationError
from uav_tracking_mpc.nodes.conversions import set_air_velocity, set_odometry, set_point
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, ODOMETRY, TARGET

pytestmark = [pytest.mark.nodes]


class Compiling:
    """A compilation that goes on until it is made to fail."""

    failed = False

    def __init__(self, folder, aside):
        pass

    def done(self):
        if self.failed:
            raise CompilationError("no compiler")
        return False


class Flight(NodeHarness):
    """A controller node that answers states of an aircraft on its orbit, as late as it is told."""

    def __init__(self, **parameters):
        quiet = {"delay_margin_min": 0.0, "gain_margin_min": 0.0, "use_sim_time": True}
        super().__init__(NmpcController, CONFIGURATION.controller, None, (), **quiet, **parameters)
        self.clock = time.monotonic()  # when it was activated
        self.statuses, self.takes = [], 0.0
        self.published = self.hear
        self.node.controller._stopwatch = lambda: self.clock
        solve = self.node.controller.formulation.solve
        self.log = mock.Mock()
        self.node.get_logger = lambda: self.log

        def slow(*arguments):
            self.clock += self.takes
            return solve(*arguments)

        self.node.controller.formulation.solve = slow

    def hear(self, topic, message):
        if topic.endswith("diagnostics"):
            self.statuses += message.status

    def state(self):
        """The next state, 50 ms after the last answer, in time."""
        self.clock += 0.05
        stamp = round(self.clock * 1e9)
        target, air, odometry = TARGET.type(), AIR_VELOCITY.type(), ODOMETRY.type()
        set_point(target, stamp, np.zeros(3))
        set_air_velocity(air, stamp, 22.0)
        turn = self.clock * 22.0 / 300.0
        place = [300.0 * np.cos(turn), 300.0 * np.sin(turn), 120.0, turn + np.pi / 2.0, 0.0, 22.0]
        set_odometry(odometry, stamp, np.array(place), np.array([22.0 / 300.0, 0.0, 0.0]))
        self.tell(TARGET.name, target)
        self.tell(AIR_VELOCITY.name, air)
        self.tell(ODOMETRY.name, odometry)


@pytest.fixture
def ros():
    start_ros()
    yield
    rclpy.try_shutdown()


def test_while_the_solver_is_compiled_that_is_the_one_status(ros, monkeypatch):
    monkeypatch.setattr(bridged_solver, "Compilation", Compiling)
    monkeypatch.setattr(bridged_solver.machine_code, "finished", lambda folder: False)
    flight = Flight()
    flight.state()
    flight.statuses.clear()
    flight.takes = 2.0
    for _ in range(6):
        flight.state()
        flight.fire()
    shown = {(status.level, status.message) for status in flight.statuses}
    assert shown == {(b"\x01", "the solver is being compiled")}
    assert flight.node.report.refused >= 2  # answers that came too late
    said = [call.args[0] for call in flight.log.warning.call_args_list]
    assert said == ["the solver is being compiled: a slower one solves meanwhile"]
    flight.log.error.assert_not_called()
    monkeypatch.setattr(Compiling, "failed", True)
    for _ in range(3):
        flight.state()
    assert flight.statuses[-1].message == "the own solve is late: no command is sent"
    flight.node.destroy_node()


def test_a_lost_state_says_who_is_late(ros):
    flight = Flight()
    modes = flight.node.controller.modes
    for _ in range(10):
        flight.state()
    flight.takes = 2.0
    for _ in range(3):
        flight.state()
        flight.fire()
        assert modes.reason == "the own solve is late"
    flight.takes = 0.0
    for _ in range(5):
        flight.state()
    assert modes.reason == ""
    flight.clock += 0.3
    flight.fire()
    flight.clock += 0.3
    flight.fire()
    assert modes.reason.endswith("nothing usable comes on uav/odometry: its sender is late or gone")
    flight.node.destroy_node()
