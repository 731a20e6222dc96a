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

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from filled_messages import filled_odometry
from node_harness import Nodes
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy

from uav_tracking_mpc.nodes.ros.declared_parameters import declare_parameters
from uav_tracking_mpc.nodes.topics import DIAGNOSTICS, ODOMETRY, TRACKING
from uav_tracking_mpc.nodes.watching.flight_watcher import FlightWatcher
from uav_tracking_mpc.settings.tracking import TrackingParameters

pytestmark = pytest.mark.nodes
STATE = [180.0, -20.0, 40.0, 2.0, 0.1, 22.0]


@pytest.fixture
def ros():
    """A watcher, somebody who sends, and whoever else is asked for."""
    ros = Nodes(EventsExecutor)
    ros.watcher = ros.join(FlightWatcher(context=ros.context))
    ros.sender = ros.peer("sender")
    yield ros
    ros.end()


def offer(ros, topic, namespace="", qos=None):
    """A publisher in a namespace."""
    return ros.sender.create_publisher(topic.type, f"{namespace}/{topic.name}", qos or topic.qos)


def state(stamp=1):
    return filled_odometry(stamp, STATE)


def test_aircraft_appear_with_what_they_say_and_stay(ros):
    watcher, best_effort = ros.watcher, ReliabilityPolicy.BEST_EFFORT
    bare = offer(ros, ODOMETRY)
    red = offer(ros, ODOMETRY, "/fleet/red", QoSProfile(depth=1, reliability=best_effort))

    def send():
        bare.publish(state(1_500_000_000))
        red.publish(state(2_500_000_000))

    def heard():
        aircraft = watcher.aircraft.values()
        return len(aircraft) == 2 and all(each.state.value is not None for each in aircraft)

    assert not watcher.aircraft
    assert ros.spin(heard, also=send)
    assert watcher.aircraft.keys() == {"/", "/fleet/red"}
    seen = watcher.aircraft["/fleet/red"].state.value
    assert seen.stamp == 2.5
    assert seen.position == pytest.approx(STATE[:3])
    ros.sender.destroy_publisher(red)
    assert ros.spin(lambda: not watcher.count_publishers(f"/fleet/red/{ODOMETRY.name}"))
    assert watcher.aircraft["/fleet/red"].state.value.stamp == 2.5


def test_what_cannot_be_used_is_told_and_the_next_one_is_used(ros):
    states = offer(ros, ODOMETRY)
    assert ros.spin(lambda: ros.watcher.aircraft, also=lambda: states.publish(state()))
    heard, wrong = ros.watcher.aircraft["/"], filled_odometry(1, [float("nan"), *STATE[1:]])
    assert ros.spin(
        lambda: heard.state.value is None and heard.state.trouble,
        also=lambda: states.publish(wrong),
    )
    assert "pose.position.x is nan" in heard.state.trouble
    assert ros.spin(lambda: heard.state.value is not None, also=lambda: states.publish(state()))
    assert not heard.state.trouble


def test_reports_go_to_the_aircraft_whose_nodes_they_are_of(ros):
    watcher, states = ros.watcher, [offer(ros, ODOMETRY), offer(ros, ODOMETRY, "/red")]
    reports = ros.sender.create_publisher(DiagnosticArray, DIAGNOSTICS.name, DIAGNOSTICS.qos)
    names = ("nmpc_controller", "red/nmpc_controller", "red/camera/tracker", "blue/nmpc_controller")
    statuses = [
        DiagnosticStatus(level=b"\x01", name=f"{name}: status", message=f"that of {name}")
        for name in names
    ]
    statuses[1].values = [KeyValue(key="mode", value="loiter law")]

    def send():
        for publisher in states:
            publisher.publish(state())
        reports.publish(DiagnosticArray(status=statuses))

    assert ros.spin(lambda: len(watcher.aircraft) == 2, also=send)
    bare, red = (watcher.aircraft[namespace] for namespace in ("/", "/red"))
    assert ros.spin(lambda: len(bare.reports) == len(red.reports) == 2, also=send)
    report = red.reports["nmpc_controller"]
    assert report.words == "that of red/nmpc_controller"
    assert report.level == 1
    assert report.values == {"mode": "loiter law"}
    assert bare.reports.keys() == {"nmpc_controller", "blue/nmpc_controller"}


class StandIn(rclpy.node.Node):
    """A node with the parameters of a controller."""

    def __init__(self, **options):
        super().__init__("nmpc_controller", **options)
        declare_parameters(self, TrackingParameters, changeable=True)


def test_parameters_are_known_and_follow_their_changes(ros):
    states = offer(ros, ODOMETRY, "/red")
    assert ros.spin(lambda: ros.watcher.aircraft, also=lambda: states.publish(state()))
    asked = ros.watcher.parameters["/red"]
    assert asked.value is None  # nobody is there to be asked
    told = TrackingParameters().range + 20.0
    controller = ros.add(StandIn, namespace="red", range=told)
    assert ros.spin(lambda: asked.value is not None)
    assert asked.value.range == told
    assert asked.value.altitude == TrackingParameters().altitude
    controller.set_parameters([Parameter("range", value=told + 10.0)])
    assert ros.spin(lambda: asked.value.range == told + 10.0)
    assert not asked.trouble


def test_a_number_is_decoded_only_when_somebody_looks(ros):
    states, topic = offer(ros, ODOMETRY), TRACKING["cost"]
    assert ros.spin(lambda: ros.watcher.aircraft, also=lambda: states.publish(state()))
    cost, costs = ros.watcher.aircraft["/"].cost, offer(ros, topic)
    read, reads = cost._read, []

    def counted(data):
        reads.append(data)
        return read(data)

    cost._read, sent = counted, []

    def send():
        sent.append(len(sent) + 1.0)
        costs.publish(topic.type(data=sent[-1]))

    assert ros.spin(lambda: cost.arrival > 0.0 and len(sent) > 20, also=send)
    assert not reads
    assert cost.value in sent
    assert cost.value in sent
    assert len(reads) == 1
