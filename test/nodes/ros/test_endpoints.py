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

"""Best-effort senders are heard, and qos_overrides take effect or end the node in words."""

from __future__ import annotations

import functools
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy
from processes import command, environment, run_node, spin
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.autopilot_link import AutopilotLink
from uav_tracking_mpc.nodes.flight_recorder import FlightRecorder
from uav_tracking_mpc.nodes.messages.conversions import set_air_velocity, set_odometry, set_point
from uav_tracking_mpc.nodes.monitor import Monitor
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
)
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.studies.faults.fault_relay import FaultRelay
from uav_tracking_mpc.studies.faults.soak import SoakObserver

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
LINK = f"{Path(__file__).parents[2] / 'paced_link.py'}:PacedLink"
KINDS = {
    UavSimulator: ("publisher", ODOMETRY, {}),
    TargetPublisher: ("publisher", TARGET, {}),
    NmpcController: ("subscription", TARGET, {}),
    AutopilotLink: ("subscription", COMMAND, {"link": LINK, "connection": "nobody"}),
}


def make(context, node_class, overrides=(), **options):
    parameters = [Parameter(name, value=value) for name, value in dict(overrides).items()]
    return node_class(context=context, parameter_overrides=parameters, **options)


def qos_of(node, kind, topic):
    name = node.resolve_topic_name(topic.name)
    infos = {
        "publisher": node.get_publishers_info_by_topic,
        "subscription": node.get_subscriptions_info_by_topic,
    }[kind](name)
    (info,) = [each for each in infos if each.node_name == node.get_name()]
    return info.qos_profile


@pytest.mark.nodes
def test_the_controller_flies_on_best_effort_odometry_air_and_target(context):
    """As MAVROS and most drivers publish."""
    executor = SingleThreadedExecutor(context=context)
    controller = make(context, NmpcController)
    driver = rclpy.create_node("driver", context=context)
    publishers = {
        topic.name: driver.create_publisher(topic.type, topic.name, BEST_EFFORT)
        for topic in (ODOMETRY, AIR_VELOCITY, TARGET, TARGET_ODOMETRY)
    }
    heard = []
    driver.create_subscription(COMMAND.type, COMMAND.name, heard.append, 10)

    def send():
        stamp = driver.get_clock().now().nanoseconds
        point, air, odometry = TARGET.type(), AIR_VELOCITY.type(), ODOMETRY.type()
        set_point(point, stamp, np.zeros(3))
        set_air_velocity(air, stamp, 4.0)
        set_odometry(odometry, stamp, np.array([180.0, 0.0, 40.0, 2.0, 0.0, 4.0]), np.zeros(3))
        for topic, message in ((TARGET, point), (AIR_VELOCITY, air), (ODOMETRY, odometry)):
            publishers[topic.name].publish(message)

    driver.create_timer(0.05, send)
    for node in (controller, driver):
        executor.add_node(node)
    deadline = time.monotonic() + 30.0
    while len(heard) < 5 and time.monotonic() < deadline:
        executor.spin_once(timeout_sec=0.05)
    assert len(heard) >= 5
    assert not controller.controller.navigator.air.missing
    assert all(publisher.get_subscription_count() for publisher in publishers.values())
    for node in (controller, driver):
        node.destroy_node()


@pytest.mark.nodes
@pytest.mark.parametrize("namespace", ["", "/uav1"])
@pytest.mark.parametrize("node_class", KINDS, ids=lambda kind: kind.__name__)
def test_overrides_take_effect_and_are_parameters(context, node_class, namespace):
    kind, topic, more = KINDS[node_class]
    name = f"qos_overrides.{namespace}/{topic.name}.{kind}.reliability"
    as_it_is = make(context, node_class, more, namespace=namespace)
    before = qos_of(as_it_is, kind, topic).reliability
    assert as_it_is.has_parameter(name)  # ros2 param list shows it
    as_it_is.destroy_node()
    other = {
        ReliabilityPolicy.RELIABLE: ReliabilityPolicy.BEST_EFFORT,
        ReliabilityPolicy.BEST_EFFORT: ReliabilityPolicy.RELIABLE,
    }[before]
    node = make(context, node_class, {**more, name: other.name.lower()}, namespace=namespace)
    assert node.get_parameter(name).value == other.name.lower()
    assert qos_of(node, kind, topic).reliability == other
    node.destroy_node()


@pytest.mark.nodes
@pytest.mark.parametrize(
    ("policy", "value", "allowed"),
    [
        ("reliability", "perhaps", "one of .*reliable, best_effort"),
        ("history", "some", "one of .*keep_last, keep_all"),
        ("depth", 0, "an integer from 1 to 10000"),
        ("depth", "deep", "an integer from 1 to 10000"),
    ],
)
def test_a_nonsense_override_is_refused_with_what_is_allowed(context, policy, value, allowed):
    name = f"qos_overrides./target/position.publisher.{policy}"
    with pytest.raises(ParameterError, match=rf"{name}' is .*{value}.*, must be {allowed}"):
        make(context, TargetPublisher, {name: value})


@pytest.mark.nodes
def test_a_nonsense_override_ends_the_process_with_one_fatal_line():
    code, output = run_node(
        "target_publisher",
        "--ros-args",
        *("-p", "qos_overrides./target/position.publisher.reliability:=perhaps"),
    )
    assert code == 2
    (fatal,) = [line for line in output.splitlines() if "FATAL" in line]
    assert "is 'perhaps', must be one of" in fatal
    assert "best_effort" in fatal
    assert "Traceback" not in output


@pytest.mark.nodes
def test_unknown_parameters_and_overrides_in_vain_are_warned_of():
    process = subprocess.Popen(
        command(
            "nodes.target_publisher",
            "--ros-args",
            *("-p", "raet:=5.0"),
            *("-p", "qos_overrides./target/positon.publisher.reliability:=best_effort"),
            *("-p", "qos_overrides./target/position.publisher.depth:=3"),
        ),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        env=environment(),
    )
    output = ""
    for line in process.stdout:
        output += line
        if "target is" in line:
            break
    process.terminate()
    output += process.communicate(timeout=60)[0]
    warnings = [line for line in output.splitlines() if "has no effect" in line]
    assert len(warnings) == 2
    assert "'raet' is unknown" in warnings[0]
    assert "/target/positon.publisher.reliability' is unknown" in warnings[1]


pytestmark = pytest.mark.nodes
TOPIC = TRACKING["cost"]


def offer(context, reliability, topic=TOPIC, depth=10):
    node = rclpy.create_node("sender", context=context)
    qos = QoSProfile(depth=depth, reliability=reliability)
    return node, node.create_publisher(topic.type, topic.name, qos)


@pytest.mark.parametrize("kind", [SingleThreadedExecutor, EventsExecutor])
def test_a_best_effort_sender_that_comes_later_is_heard(context, kind):
    heard = []
    node = rclpy.create_node("listener", context=context)
    overhearing = FollowingSubscription(node, TOPIC, heard.append, 100)
    executor = kind(context=context)
    executor.add_node(node)
    first, reliable = offer(context, ReliabilityPolicy.RELIABLE)
    assert spin(executor, lambda: overhearing.senders == 1)
    second, best_effort = offer(context, ReliabilityPolicy.BEST_EFFORT)
    assert spin(executor, lambda: overhearing.senders == 2)

    def both():
        reliable.publish(TOPIC.type(data=1.0))
        best_effort.publish(TOPIC.type(data=2.0))
        return {message.data for message in heard} == {1.0, 2.0}

    assert spin(executor, both)
    for each in (node, first, second):
        each.destroy_node()


def test_no_message_of_a_reliable_sender_is_lost(context):
    heard = []
    node = rclpy.create_node("listener", context=context)
    overhearing = FollowingSubscription(node, TOPIC, heard.append, 2000, raw=True)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    sender, publisher = offer(context, ReliabilityPolicy.RELIABLE, depth=2000)
    assert spin(executor, lambda: overhearing.senders == 1)
    for value in range(1000):
        publisher.publish(TOPIC.type(data=float(value)))
    assert spin(executor, lambda: len(heard) == 1000)
    info = node.get_subscriptions_info_by_topic(f"/{TOPIC.name}")
    assert [each.qos_profile.reliability for each in info] == [ReliabilityPolicy.RELIABLE]
    for each in (node, sender):
        each.destroy_node()


@pytest.mark.parametrize(
    "make",
    [Monitor, FlightRecorder, FaultRelay, functools.partial(SoakObserver, 150.0)],
    ids=["monitor", "flight_recorder", "fault_relay", "soak_observer"],
)
def test_everybody_who_looks_follows_the_senders(context, make):
    looking = make(context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(looking)
    subscription = next(
        each
        for each in looking.subscriptions
        if each.topic_name not in (DIAGNOSTICS.name, "/clock", "/torture/fault")
    )
    sender = rclpy.create_node("sender", context=context)
    qos = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = sender.create_publisher(subscription.msg_type, subscription.topic_name, qos)
    assert spin(executor, lambda: publisher.get_subscription_count() >= 1)
    for each in (looking, sender):
        each.destroy_node()
