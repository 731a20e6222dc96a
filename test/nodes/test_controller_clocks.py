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

"""A controller node by clocks of the test: slow solves, and simulated time that is fast.

What is lost for a moment of the wall's time is lost for long in a fast one.
"""

import time
from dataclasses import replace
from unittest import mock

import pytest
from controller_flight import CONFIGURATION
from filled_messages import circling, filled_air, filled_clock, filled_odometry, filled_point
from node_harness import NodeHarness, silent_ros

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.mpc import compiled_method
from uav_tracking_mpc.mpc.compiled_method import CompilationError
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, COMMAND, ODOMETRY, TARGET

pytestmark = [pytest.mark.nodes]

TICK = 0.05  # s of simulated time


class Flight(NodeHarness):
    """A controller node in simulated time that has answered ten states; its log is kept.

    Args:
        speed: Simulated over steady time.
        changes: Of the controller's parameters.
    """

    def __init__(self, speed=1.0, **changes):
        quiet = {"delay_margin_min": 0.0, "gain_margin_min": 0.0, "use_sim_time": True}
        parameters = replace(CONFIGURATION.controller, **changes)
        super().__init__(NmpcController, parameters, None, (), **quiet)
        self.clock = time.monotonic()  # when it was activated
        self.time, self.speed, self.answers, self.statuses = 100.0, speed, [], []
        self.published = self.hear
        self.node.controller._stopwatch = self.now
        self.log = mock.Mock()
        self.node.get_logger = lambda: self.log
        for _ in range(11):  # the first state has no airspeed yet
            self.tick()
        assert len(self.answers) == 10

    def hear(self, topic, message):
        if topic == COMMAND.name:
            self.answers.append(message)
        elif topic.endswith("diagnostics"):
            self.statuses += message.status

    def tick(self):
        self.wait(TICK)
        self.target()
        self.state()

    def wait(self, time):
        """Simulated time passes in [s], and as much of it on the steady clock."""
        self.time += time
        self.clock += time / self.speed
        self.tell(CLOCK.name, filled_clock(round(self.time * 1e9)))

    def target(self, ahead=0.0):
        self.tell(TARGET.name, filled_point(round((self.time + ahead) * 1e9)))

    def state(self, ahead=0.0):
        stamp = round((self.time + ahead) * 1e9)
        self.tell(ODOMETRY.name, filled_odometry(stamp, *circling(self.time + ahead)))
        self.tell(AIR_VELOCITY.name, filled_air(stamp, 22.0))  # as the simulator sends them

    @property
    def warned(self):
        """All warnings, in words."""
        return [call.args[0] for call in self.log.warning.call_args_list]


@pytest.fixture
def make():
    """Makes the flight."""
    made = []

    def make(**how):
        made.append(Flight(**how))
        return made[-1]

    with silent_ros():
        yield make
        for each in made:
            each.node.destroy_node()


@pytest.fixture
def slow(make):
    """Makes a flight whose solves take so long as its ``takes`` says in [s]."""

    def slow():
        flight = make()
        flight.takes, solve = 0.0, flight.node.controller.formulation.solve

        def late(*arguments):
            flight.clock += flight.takes
            return solve(*arguments)

        flight.node.controller.formulation.solve = late
        return flight

    return slow


class Compiling:
    """A compilation that goes on until it is made to fail."""

    failed = False

    def __init__(self, folder, aside):
        pass

    def done(self):
        if self.failed:
            raise CompilationError("no compiler")
        return False


def test_while_the_solver_is_compiled_that_is_the_one_status(slow, monkeypatch):
    monkeypatch.setattr(compiled_method, "Compilation", Compiling)
    monkeypatch.setattr(compiled_method.machine_code, "finished", lambda folder: False)
    flight = slow()
    flight.statuses.clear()
    flight.takes = 2.0
    for _ in range(6):
        flight.tick()
        flight.fire()
    shown = {(status.level, status.message) for status in flight.statuses}
    assert shown == {(b"\x01", "the solver is being compiled")}
    assert flight.node.report.refused >= 2  # answers that came too late
    assert flight.warned == ["the solver is being compiled: a slower one solves meanwhile"]
    flight.log.error.assert_not_called()
    monkeypatch.setattr(Compiling, "failed", True)
    for _ in range(3):
        flight.tick()
    assert flight.statuses[-1].message == "the own solve is late: no command is sent"


def test_a_lost_state_says_who_is_late(slow):
    Controller(CONFIGURATION.controller)  # which waits for the compiler
    flight = slow()
    modes = flight.node.controller.modes
    flight.takes = 2.0
    for _ in range(3):
        flight.tick()
        flight.fire()
        assert modes.reason == "the own solve is late"
    flight.takes = 0.0
    for _ in range(5):
        flight.tick()
    assert modes.reason == ""
    for _ in range(2):
        flight.wait(0.3)
        flight.fire()
    assert modes.reason.endswith(
        "nothing usable comes on uav/odometry: its sender is late, gone or stuck"
    )


@pytest.fixture
def flight(make):
    return make(speed=10.0, law="l1")  # no solve, which may be late


@pytest.mark.parametrize("gap", [0.7, 2.0])
def test_messages_that_get_lost_are_no_stamps_that_go_ahead(flight, gap):
    """In 0.2 s of standing still a process misses 2 s of states; it answers the next one."""
    flight.wait(gap)
    flight.target()
    flight.state()
    assert flight.warned == []
    assert flight.node.report.refused == 0
    assert len(flight.answers) == 11


def test_a_state_that_came_late_puts_no_target_ahead(flight):
    """The clock has gone on while the state waited: it is the state that is old."""
    flight.wait(0.55)
    flight.state(ahead=-0.5)
    flight.wait(TICK)
    flight.target()
    flight.wait(0.5)
    flight.state()
    assert flight.warned == []


def test_a_state_ahead_of_simulated_time_is_doubted(flight):
    flight.wait(TICK)
    flight.state(ahead=2.0)
    (words,) = flight.warned
    assert "the stamp went ahead by 2.050 s; used if the next ones agree" in words
    assert len(flight.answers) == 10


@pytest.mark.parametrize("gap", [TICK, 0.7])
def test_a_target_ahead_of_simulated_time_is_refused(flight, gap):
    flight.wait(gap)
    flight.target(ahead=2.0)
    (words,) = flight.warned
    assert words.endswith("may be 0.5 s: do the clocks agree?")


def test_of_targets_alone_it_says_that_states_are_missing(flight):
    flight.wait(CONFIGURATION.controller.target_timeout + 0.5)
    flight.target()
    (words,) = flight.warned
    assert words.endswith("no newer state has come")
