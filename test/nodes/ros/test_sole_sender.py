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

import subprocess

import pytest
import rclpy
from processes import DOMAIN, KILL, command, environment, spin
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.parameter import Parameter

from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.ros import diagnostics
from uav_tracking_mpc.nodes.ros.sole_sender import (
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
def context():
    context = rclpy.Context()
    context.init(args=[], domain_id=int(DOMAIN))
    yield context
    context.try_shutdown()


@pytest.mark.nodes
def test_two_controllers_and_two_simulators_are_errors_while_they_last(context):
    executor = SingleThreadedExecutor(context=context)
    says = {}
    listener = rclpy.create_node("listener", context=context)

    def on_diagnostics(message):
        for status in message.status:
            says[status.name.partition(":")[0]] = (status.level, status.message)

    listener.create_subscription(DIAGNOSTICS.type, DIAGNOSTICS.name, on_diagnostics, 100)
    executor.add_node(listener)

    def add(node_class, name="", **parameters):
        overrides = [Parameter(key, value=value) for key, value in parameters.items()]
        rename = ["--ros-args", "-r", f"__node:={name}"] if name else []
        node = node_class(context=context, parameter_overrides=overrides, cli_args=rename)
        executor.add_node(node)
        return node

    def error(node, *words):
        level, message = says.get(node, (b"\x00", ""))
        return level == diagnostics.ERROR and all(word in message for word in words)

    add(TargetPublisher)
    controller, simulator = add(NmpcController), add(UavSimulator)
    assert spin(executor, lambda: says.get("uav_simulator", "") and controller.report)
    assert spin(executor, lambda: says["uav_simulator"][1] == "flying on commands")
    assert not any(level == diagnostics.ERROR for level, _ in says.values())

    second = add(NmpcController, "other_controller")
    words = "/uav/command has 2 senders, must have one: /nmpc_controller, /other_controller"
    observers = ("uav_simulator", "nmpc_controller", "other_controller")
    assert spin(executor, lambda: all(error(node, words) for node in observers)), says
    executor.remove_node(second)
    second.destroy_node()
    assert spin(executor, lambda: says["uav_simulator"][0] == diagnostics.OK), says

    other = add(UavSimulator, "other_simulator", initial_position=[0.0, 180.0, 40.0])
    words = ("/uav/odometry has 2 senders", "/uav/air_velocity has 2 senders", "/other_simulator")
    assert spin(executor, lambda: error("nmpc_controller", *words)), says
    executor.remove_node(other)
    other.destroy_node()
    clear = spin(executor, lambda: says["nmpc_controller"][0] != diagnostics.ERROR)
    assert clear, says
    for node in (controller, simulator, listener):
        node.destroy_node()


@pytest.mark.nodes
def test_a_killed_and_restarted_sender_is_no_second_one(context):
    """By the executor of the nodes; its dead endpoint stays known for 20 s."""
    said, counts = [], []
    node = rclpy.create_node("listener", context=context)
    senders = DuplicateSenders(node, (TARGET,), said.append)
    executor = EventsExecutor(context=context)
    executor.add_node(node)

    def start():
        return subprocess.Popen(
            command("nodes.target_publisher"),
            env=environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def known():
        counts.append(node.count_publishers("/target/position"))
        return counts[-1]

    process = start()
    try:
        assert spin(executor, lambda: known() == 1)
        process.send_signal(KILL)
        process.wait()
        process = start()
        assert spin(executor, lambda: known() == 2)
        spin(executor, lambda: False, 2.0 * WINDOW)
        assert max(counts) == 2
        assert said == []
    finally:
        process.kill()
        process.wait()
        node.destroy_node()
    assert senders is not None
