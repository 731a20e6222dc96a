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

"""Aircraft are found as they appear, and heard with their controllers' parameters."""

import time

import numpy as np
import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.messages.conversions import set_odometry
from uav_tracking_mpc.nodes.ros.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, ODOMETRY, TRACKING
from uav_tracking_mpc.nodes.watching import FlightWatcher
from uav_tracking_mpc.settings.tracking import TrackingParameters

pytestmark = pytest.mark.nodes
STATE = np.array([180.0, -20.0, 40.0, 2.0, 0.1, 22.0])


@pytest.fixture
def ros():
    """A watcher, whoever else is asked for, and what spins them."""
    context = rclpy.Context()
    context.init(args=[])
    executor = EventsExecutor(context=context)
    nodes = []

    def add(make, *arguments, **options):
        nodes.append(make(*arguments, context=context, **options))
        executor.add_node(nodes[-1])
        return nodes[-1]

    def spin(until, meanwhile=lambda: None, limit=60.0):
        deadline = time.monotonic() + limit
        while time.monotonic() < deadline:
            executor.spin_once(timeout_sec=0.05)
            meanwhile()
            if until():
                return True
        return False

    add.spin = spin
    yield add
    for node in nodes:
        node.destroy_node()
    context.try_shutdown()


def send_state(publisher, stamp):
    message = ODOMETRY.type()
    set_odometry(message, stamp, STATE, np.zeros(3))
    publisher.publish(message)


def test_aircraft_appear_with_what_they_say_and_stay(ros):
    watcher, sender = ros(FlightWatcher), ros(rclpy.create_node, "sender")
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    bare = sender.create_publisher(ODOMETRY.type, f"/{ODOMETRY.name}", ODOMETRY.qos)
    red = sender.create_publisher(ODOMETRY.type, f"/fleet/red/{ODOMETRY.name}", best_effort)

    def send():
        send_state(bare, 1_500_000_000)
        send_state(red, 2_500_000_000)

    def heard():
        aircraft = watcher.aircraft.values()
        return len(aircraft) == 2 and all(each.state.value is not None for each in aircraft)

    assert not watcher.aircraft
    assert ros.spin(heard, send)
    assert watcher.aircraft.keys() == {"/", "/fleet/red"}
    state = watcher.aircraft["/fleet/red"].state.value
    assert state.stamp == 2.5
    np.testing.assert_allclose(state.position, STATE[:3])
    sender.destroy_publisher(red)
    assert ros.spin(lambda: not watcher.count_publishers(f"/fleet/red/{ODOMETRY.name}"))
    assert watcher.aircraft["/fleet/red"].state.value.stamp == 2.5


def test_what_cannot_be_used_is_told_and_the_next_one_is_used(ros):
    watcher, sender = ros(FlightWatcher), ros(rclpy.create_node, "sender")
    states = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
    assert ros.spin(lambda: watcher.aircraft, lambda: send_state(states, 1))
    heard = watcher.aircraft["/"]
    wrong = ODOMETRY.type()
    wrong.pose.pose.position.x = float("nan")
    assert ros.spin(
        lambda: heard.state.value is None and heard.state.trouble, lambda: states.publish(wrong)
    )
    assert "pose.position.x is nan" in heard.state.trouble
    assert ros.spin(lambda: heard.state.value is not None, lambda: send_state(states, 1))
    assert not heard.state.trouble


def test_reports_go_to_the_aircraft_whose_nodes_they_are_of(ros):
    watcher, sender = ros(FlightWatcher), ros(rclpy.create_node, "sender")
    states = [
        sender.create_publisher(ODOMETRY.type, f"{name}/{ODOMETRY.name}", ODOMETRY.qos)
        for name in ("", "/red")
    ]
    reports = sender.create_publisher(DiagnosticArray, DIAGNOSTICS.name, DIAGNOSTICS.qos)
    names = ("nmpc_controller", "red/nmpc_controller", "red/camera/tracker", "blue/nmpc_controller")
    statuses = [
        DiagnosticStatus(level=b"\x01", name=f"{name}: status", message=f"that of {name}")
        for name in names
    ]
    statuses[1].values = [KeyValue(key="mode", value="loiter law")]

    def send():
        for publisher in states:
            send_state(publisher, 1)
        reports.publish(DiagnosticArray(status=statuses))

    assert ros.spin(lambda: len(watcher.aircraft) == 2, send)
    bare, red = (watcher.aircraft[namespace] for namespace in ("/", "/red"))
    assert ros.spin(lambda: len(bare.reports) == len(red.reports) == 2, send)
    assert red.reports["nmpc_controller"].words == "that of red/nmpc_controller"
    assert red.reports["nmpc_controller"].level == 1
    assert red.reports["nmpc_controller"].values == {"mode": "loiter law"}
    assert bare.reports.keys() == {"nmpc_controller", "blue/nmpc_controller"}


class StandIn(rclpy.node.Node):
    """A node with the parameters of a controller."""

    def __init__(self, **options):
        super().__init__("nmpc_controller", namespace="red", **options)
        declare_parameters(self, TrackingParameters, changeable=True)


def test_parameters_are_known_and_follow_their_changes(ros):
    watcher, sender = ros(FlightWatcher), ros(rclpy.create_node, "sender")
    states = sender.create_publisher(ODOMETRY.type, f"/red/{ODOMETRY.name}", ODOMETRY.qos)
    assert ros.spin(lambda: watcher.aircraft, lambda: send_state(states, 1))
    asked = watcher.parameters["/red"]
    assert asked.value is None  # nobody is there to be asked
    told = TrackingParameters().range + 20.0
    controller = ros(StandIn, parameter_overrides=[Parameter("range", value=told)])
    assert ros.spin(lambda: asked.value is not None)
    assert asked.value.range == told
    assert asked.value.altitude == TrackingParameters().altitude
    controller.set_parameters([Parameter("range", value=told + 10.0)])
    assert ros.spin(lambda: asked.value.range == told + 10.0)
    assert not asked.trouble


def test_a_number_is_decoded_only_when_somebody_looks(ros):
    watcher, sender = ros(FlightWatcher), ros(rclpy.create_node, "sender")
    states = sender.create_publisher(ODOMETRY.type, ODOMETRY.name, ODOMETRY.qos)
    assert ros.spin(lambda: watcher.aircraft, lambda: send_state(states, 1))
    cost, topic = watcher.aircraft["/"].cost, TRACKING["cost"]
    costs = sender.create_publisher(topic.type, topic.name, topic.qos)
    read, reads = cost._read, []

    def counted(data):
        reads.append(data)
        return read(data)

    cost._read, sent = counted, []

    def send():
        sent.append(len(sent) + 1.0)
        costs.publish(topic.type(data=sent[-1]))

    assert ros.spin(lambda: cost.arrival > 0.0 and len(sent) > 20, send)
    assert not reads
    assert cost.value in sent
    assert cost.value in sent
    assert len(reads) == 1
