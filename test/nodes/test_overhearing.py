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

"""Who only looks hears best-effort senders, and every message of reliable ones."""

from __future__ import annotations

import functools

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy
from waiting import spin

from uav_tracking_mpc.nodes.flight_recorder import FlightRecorder
from uav_tracking_mpc.nodes.monitor import Monitor
from uav_tracking_mpc.nodes.overhearing import Overhearing
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, TRACKING
from uav_tracking_mpc.studies.faults.fault_relay import FaultRelay
from uav_tracking_mpc.studies.faults.soak import SoakObserver

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
    overhearing = Overhearing(node, TOPIC, heard.append, 100)
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
    overhearing = Overhearing(node, TOPIC, heard.append, 2000, raw=True)
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
