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

"""A second sender is an error in words while it lasts; a restarted one is none."""

from __future__ import annotations

import pytest
from node_harness import Nodes
from processes import DOMAIN, KILL, ended, started
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor

from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.diagnostics import (
    FALLS,
    UNNUMBERED,
    WINDOW,
    DuplicateSenders,
    InterleavedSequences,
)
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, TARGET
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator


def turns(numbers, period=0.1):
    heard = InterleavedSequences(0.0)
    for index, number in enumerate(numbers):
        heard.see(number, period * index)
    return heard, period * len(numbers)


def test_two_streams_of_numbers_are_two_senders():
    heard, now = turns([500, 3, 501, 4, 502, 5, 503, 6])
    assert heard.holds(now)
    assert not heard.holds(now + WINDOW + 1.0)  # it is over when one of them has fallen silent


def test_two_slow_senders_are_two_without_a_pause():
    """Two targets at 0.4 Hz, which is often enough for a target."""
    heard = InterleavedSequences(0.0)
    told = []
    for index, number in enumerate([500, 3, 501, 4, 502, 5, 503, 6, 504, 7]):
        heard.see(number, 1.25 * index)
        told.append(heard.holds(1.25 * index))
    assert told == sorted(told)  # once begun it goes on
    assert told[-1]


def test_equal_numbers_are_two_senders():
    heard, now = turns([7, 7, 8, 8, 9, 9])
    assert heard.holds(now)


@pytest.mark.parametrize(
    "numbers", [range(100), [1, 2, 5, 9, 40], [500, 501, 1, 2, 3, 4], [9, 10, 1, 2, 1, 2, 3]]
)
def test_one_sender_lost_messages_and_restarts_are_none(numbers):
    heard, now = turns(list(numbers))
    assert not heard.holds(now)


def test_falls_that_lie_far_apart_are_restarts():
    heard, now = turns([5, 1] * FALLS, period=WINDOW)
    assert not heard.holds(now)


def test_without_numbers_a_dead_publisher_is_waited_for():
    heard, now = turns([None] * 10)
    assert not heard.holds(now)
    assert heard.holds(UNNUMBERED + 1.0)


@pytest.fixture
def nodes(request):
    """In the domain of processes."""
    nodes = Nodes(request.param, domain_id=int(DOMAIN))
    yield nodes
    nodes.end()


@pytest.mark.nodes
@pytest.mark.parametrize("nodes", [SingleThreadedExecutor], indirect=True)
def test_two_controllers_and_two_simulators_are_errors_while_they_last(nodes):
    heard = nodes.listen(DIAGNOSTICS)[DIAGNOSTICS.name]

    def says(node):
        statuses = [s for message in heard for s in message.status if s.name == f"{node}: status"]
        return (statuses[-1].level, statuses[-1].message) if statuses else (b"\x00", "")

    def error(node, *words):
        level, message = says(node)
        return level == diagnostics.ERROR and all(word in message for word in words)

    nodes.add(TargetPublisher)
    nodes.add(NmpcController)
    nodes.add(UavSimulator)
    assert nodes.spin(lambda: says("uav_simulator")[1] == "flying on commands")
    assert not any(s.level == diagnostics.ERROR for message in heard for s in message.status)

    second = nodes.add(NmpcController, ["--ros-args", "-r", "__node:=other_controller"])
    words = "/uav/command has 2 senders, must have one: /nmpc_controller, /other_controller"
    observers = ("uav_simulator", "nmpc_controller", "other_controller")
    assert nodes.spin(lambda: all(error(node, words) for node in observers))
    nodes.remove(second)
    assert nodes.spin(lambda: says("uav_simulator")[0] == diagnostics.OK)

    rename = ["--ros-args", "-r", "__node:=other_simulator"]
    other = nodes.add(UavSimulator, rename, initial_position=[0.0, 180.0, 40.0])
    words = ("/uav/odometry has 2 senders", "/uav/air_velocity has 2 senders", "/other_simulator")
    assert nodes.spin(lambda: error("nmpc_controller", *words))
    nodes.remove(other)
    assert nodes.spin(lambda: says("nmpc_controller")[0] != diagnostics.ERROR)


@pytest.mark.nodes
@pytest.mark.parametrize("nodes", [EventsExecutor], indirect=True)
def test_a_killed_and_restarted_sender_is_no_second_one(nodes):
    """By the executor of the nodes; its dead endpoint stays known for 20 s."""
    said, counts, node = [], [], nodes.peer("listener")
    heard = nodes.listen(TARGET, by=node)[TARGET.name]
    senders = DuplicateSenders(node, (TARGET,), said.append)

    def known():
        counts.append(node.count_publishers("/target/position"))
        return counts[-1]

    with started("nodes.target_publisher") as process:
        assert nodes.spin(lambda: known() == 1)
        ended(process, KILL)
    with started("nodes.target_publisher"):
        assert nodes.spin(lambda: known() == 2)
        heard.clear()
        assert nodes.spin(lambda: len(heard) > 30)
        assert max(counts) == 2
        assert said == []
    assert senders is not None
