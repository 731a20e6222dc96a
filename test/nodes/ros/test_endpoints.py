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

import pytest
from filled_messages import sensed
from node_harness import ending
from paced_link import LINK
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.autopilot_link import AutopilotLink
from uav_tracking_mpc.nodes.flight_recorder import FlightRecorder
from uav_tracking_mpc.nodes.monitor import Monitor
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.ros.endpoints import FollowingSubscription
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import (
    COMMAND,
    DIAGNOSTICS,
    ODOMETRY,
    TARGET,
    TARGET_ODOMETRY,
    TRACKING,
)
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.faults.fault_relay import FaultRelay
from uav_tracking_mpc.studies.faults.invariants import Recovery
from uav_tracking_mpc.studies.faults.node_campaign import limits
from uav_tracking_mpc.studies.faults.observer import Observer

pytestmark = pytest.mark.nodes
TOPIC = TRACKING["cost"]
BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
KINDS = {
    UavSimulator: ("publisher", ODOMETRY, {}),
    TargetPublisher: ("publisher", TARGET, {}),
    NmpcController: ("subscription", TARGET, {}),
    AutopilotLink: ("subscription", COMMAND, {"link": LINK, "connection": "nobody"}),
}


def qos_of(node, kind, topic):
    name = node.resolve_topic_name(topic.name)
    infos = {
        "publisher": node.get_publishers_info_by_topic,
        "subscription": node.get_subscriptions_info_by_topic,
    }[kind](name)
    (info,) = [each for each in infos if each.node_name == node.get_name()]
    return info.qos_profile


def test_the_controller_flies_on_best_effort_odometry_air_and_target(nodes):
    """As MAVROS and most drivers publish."""
    controller, heard = nodes.add(NmpcController), nodes.listen(COMMAND)[COMMAND.name]
    state, now = [180.0, 0.0, 40.0, 2.0, 0.0, 4.0], controller.get_clock().now
    publishers = nodes.send(lambda: sensed(now().nanoseconds, state), qos=BEST_EFFORT)
    tracker = offer(nodes, ReliabilityPolicy.BEST_EFFORT, TARGET_ODOMETRY)
    assert nodes.spin(lambda: len(heard) >= 5)
    assert not controller.controller.navigator.air.missing
    assert all(each.get_subscription_count() for each in (tracker, *publishers.values()))


@pytest.mark.parametrize("namespace", ["", "/uav1"])
@pytest.mark.parametrize("node_class", KINDS, ids=lambda kind: kind.__name__)
def test_overrides_take_effect_and_are_parameters(nodes, node_class, namespace):
    kind, topic, more = KINDS[node_class]
    name = f"qos_overrides.{namespace}/{topic.name}.{kind}.reliability"
    as_it_is = nodes.add(node_class, namespace=namespace, **more)
    before = qos_of(as_it_is, kind, topic).reliability
    assert as_it_is.has_parameter(name)  # ros2 param list shows it
    nodes.remove(as_it_is)
    other = {
        ReliabilityPolicy.RELIABLE: ReliabilityPolicy.BEST_EFFORT,
        ReliabilityPolicy.BEST_EFFORT: ReliabilityPolicy.RELIABLE,
    }[before]
    node = nodes.add(node_class, namespace=namespace, **{**more, name: other.name.lower()})
    assert node.get_parameter(name).value == other.name.lower()
    assert qos_of(node, kind, topic).reliability == other


@pytest.mark.parametrize(
    ("policy", "value", "allowed"),
    [
        ("reliability", "perhaps", "one of .*reliable, best_effort"),
        ("history", "some", "one of .*keep_last, keep_all"),
        ("depth", 0, "an integer from 1 to 10000"),
        ("depth", "deep", "an integer from 1 to 10000"),
    ],
)
def test_a_nonsense_override_is_refused_with_what_is_allowed(nodes, policy, value, allowed):
    name = f"qos_overrides./target/position.publisher.{policy}"
    with pytest.raises(ParameterError, match=rf"{name}' is .*{value}.*, must be {allowed}"):
        nodes.add(TargetPublisher, **{name: value})


def test_unknown_parameters_and_overrides_in_vain_are_warned_of(run_here):
    arguments = (
        *("-p", "raet:=5.0"),
        *("-p", "qos_overrides./target/positon.publisher.reliability:=best_effort"),
        *("-p", "qos_overrides./target/position.publisher.depth:=3"),
    )
    how = "target_publisher", lambda: ending(TargetPublisher()), "--ros-args"
    code, output = run_here(*how, *arguments)
    assert code == 0
    warnings = [line for line in output.splitlines() if "has no effect" in line]
    assert len(warnings) == 2
    assert "'raet' is unknown" in warnings[0]
    assert "/target/positon.publisher.reliability' is unknown" in warnings[1]


def offer(nodes, reliability, topic=TOPIC, depth=10):
    """A publisher of a node of its own."""
    qos = QoSProfile(depth=depth, reliability=reliability)
    return nodes.peer("sender").create_publisher(topic.type, topic.name, qos)


@pytest.mark.parametrize("nodes", [SingleThreadedExecutor, EventsExecutor], indirect=True)
def test_a_best_effort_sender_that_comes_later_is_heard(nodes):
    heard = []
    overhearing = FollowingSubscription(nodes.peer("listener"), TOPIC, heard.append, 100)
    reliable = offer(nodes, ReliabilityPolicy.RELIABLE)
    assert nodes.spin(lambda: overhearing.senders == 1)
    best_effort = offer(nodes, ReliabilityPolicy.BEST_EFFORT)
    assert nodes.spin(lambda: overhearing.senders == 2)

    def both():
        reliable.publish(TOPIC.type(data=1.0))
        best_effort.publish(TOPIC.type(data=2.0))
        return {message.data for message in heard} == {1.0, 2.0}

    assert nodes.spin(both)


def test_no_message_of_a_reliable_sender_is_lost(nodes):
    node, heard = nodes.peer("listener"), []
    overhearing = FollowingSubscription(node, TOPIC, heard.append, 2000, raw=True)
    publisher = offer(nodes, ReliabilityPolicy.RELIABLE, depth=2000)
    assert nodes.spin(lambda: overhearing.senders == 1)
    for value in range(1000):
        publisher.publish(TOPIC.type(data=float(value)))
    assert nodes.spin(lambda: len(heard) == 1000)
    info = node.get_subscriptions_info_by_topic(f"/{TOPIC.name}")
    assert [each.qos_profile.reliability for each in info] == [ReliabilityPolicy.RELIABLE]


def observer(**options):
    limit = limits(load_configuration("paper"))
    return Observer(limit, (150.0, 50.0), Recovery(10.0), [], relayed=False, **options)


@pytest.mark.parametrize(
    "make",
    [Monitor, FlightRecorder, FaultRelay, observer],
    ids=["monitor", "flight_recorder", "fault_relay", "observer"],
)
def test_everybody_who_looks_follows_the_senders(nodes, make):
    looking = nodes.join(make(context=nodes.context))
    subscription = next(
        each
        for each in looking.subscriptions
        if each.topic_name not in (DIAGNOSTICS.name, "/clock", "/torture/fault")
    )
    publisher = nodes.peer("sender").create_publisher(
        subscription.msg_type, subscription.topic_name, BEST_EFFORT
    )
    assert nodes.spin(lambda: publisher.get_subscription_count() >= 1)
