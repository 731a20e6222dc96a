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

"""What a node prints with --help, compared with the real node."""

import importlib

import pytest
import rclpy
from processes import run_node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from uav_tracking_mpc.nodes.node_help import HEARD, SERVICES, help_text, sent
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.configuration import SECTIONS

pytestmark = pytest.mark.nodes
CLASSES = {
    "uav_simulator": "UavSimulator",
    "target_publisher": "TargetPublisher",
    "nmpc_controller": "NmpcController",
    "monitor": "Monitor",
}


@pytest.mark.parametrize("name", HEARD)
def test_help_says_what_the_node_is_for_and_ends_with_code_0(name):
    code, output = run_node(name, "--help")
    assert code == 0, output
    assert f"usage: ros2 run uav_tracking_mpc {name}" in output
    assert "--params-file FILE" in output
    assert "/diagnostics (diagnostic_msgs/msg/DiagnosticArray)" in output
    for item in specifications(SECTIONS[name]) if name in SECTIONS else ():
        assert f"  {item.name} (" in output


@pytest.mark.parametrize(("name", "kind"), CLASSES.items())
def test_its_topics_are_those_of_the_real_node(name, kind):
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    more = {"publish_clock": True} if name == "uav_simulator" else {}
    overrides = [Parameter(key, value=value) for key, value in more.items()]
    node = getattr(importlib.import_module(f"uav_tracking_mpc.nodes.{name}"), kind)(
        parameter_overrides=overrides
    )
    try:
        own = {"/rosout", "/parameter_events"}
        heard = {subscription.topic_name for subscription in node.subscriptions} - own
        published = {publisher.topic_name for publisher in node.publishers} - own
        if name == "monitor":
            node.finish()
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    assert {topic.name.lstrip("/") for topic in HEARD[name]} == {t.lstrip("/") for t in heard}
    lifecycle = {t for t in published if t.endswith("transition_event")}
    told = {topic.name.lstrip("/") for topic in sent(name)} - {"rosout"}  # of rcl, not of rclpy
    assert told == {t.lstrip("/") for t in published - lifecycle}


def test_services_are_named():
    for name, words in SERVICES.items():
        for line in words:
            assert line.split()[0] in help_text(name, "")
