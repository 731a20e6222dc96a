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

"""Simulated time faster than the wall's: what is lost for a moment is lost for long in its time."""

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

pytest.importorskip("rclpy")

import rclpy
from controller_flight import CONFIGURATION
from node_harness import NodeHarness, start_ros

from uav_tracking_mpc.nodes.messages.conversions import (
    set_air_velocity,
    set_odometry,
    set_point,
    set_stamp,
)
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, CLOCK, ODOMETRY, TARGET

pytestmark = [pytest.mark.nodes]

SPEED = 10.0  # times real time
TICK = 0.05  # s of simulated time


class Flight(NodeHarness):
    """A controller node in simulated time that has answered ten states; its log is kept."""

    def __init__(self):
        quiet = {"delay_margin_min": 0.0, "gain_margin_min": 0.0, "use_sim_time": True}
        parameters = replace(CONFIGURATION.controller, law="l1")  # no solve, which may be late
        super().__init__(NmpcController, parameters, None, (), **quiet)
        self.time, self.answers = 100.0, []
        self.published = self.hear
        self.node.controller._stopwatch = lambda: self.clock
        self.log = mock.Mock()
        self.node.get_logger = lambda: self.log
        for _ in range(11):  # the first state has no airspeed yet
            self.wait(TICK)
            self.target()
            self.state()
        assert len(self.answers) == 10

    def hear(self, topic, message):
        if topic.endswith("uav/command"):
            self.answers.append(message)

    def wait(self, time):
        """Simulated time passes in [s], and a tenth of it on the steady clock."""
        self.time += time
        self.clock += time / SPEED
        message = CLOCK.type()
        set_stamp(message.clock, round(self.time * 1e9))
        self.tell(CLOCK.name, message)

    def target(self, ahead=0.0):
        message = TARGET.type()
        set_point(message, round((self.time + ahead) * 1e9), np.zeros(3))
        self.tell(TARGET.name, message)

    def state(self, ahead=0.0):
        stamp = round((self.time + ahead) * 1e9)
        air, odometry = AIR_VELOCITY.type(), ODOMETRY.type()
        set_air_velocity(air, stamp, 22.0)
        turn = (self.time + ahead) * 22.0 / 300.0
        place = [300.0 * np.cos(turn), 300.0 * np.sin(turn), 120.0, turn + np.pi / 2.0, 0.0, 22.0]
        set_odometry(odometry, stamp, np.array(place), np.array([22.0 / 300.0, 0.0, 0.0]))
        self.tell(ODOMETRY.name, odometry)
        self.tell(AIR_VELOCITY.name, air)  # as the simulator sends them

    @property
    def warned(self):
        """All warnings, in words."""
        return [call.args[0] for call in self.log.warning.call_args_list]


@pytest.fixture
def flight():
    start_ros()
    flight = Flight()
    yield flight
    flight.node.destroy_node()
    rclpy.try_shutdown()


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
