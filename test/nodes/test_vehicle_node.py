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

"""The transform for /tf is the pose of the odometry."""

from __future__ import annotations

import importlib.util
import sys
from types import ModuleType
from unittest import mock

import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from uav_tracking_mpc.dynamics.frames import FORWARD_RIGHT_DOWN, NORTH_EAST_DOWN
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds
from uav_tracking_mpc.nodes.topics import ODOMETRY
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator


class TFMessage:
    """As of tf2_msgs."""

    def __init__(self, transforms=()):
        self.transforms = list(transforms)


class Publisher:
    """Keeps what is published on a topic."""

    def __init__(self, qos):
        self.qos, self.sent, self.listeners = qos, [], 1

    def get_subscription_count(self):
        return self.listeners

    def publish(self, message):
        assert isinstance(message, TFMessage)
        for each in message.transforms:
            place, q = each.transform.translation, each.transform.rotation
            self.sent.append(
                (each.header.frame_id, each.child_frame_id, nanoseconds(each.header.stamp),
                 (place.x, place.y, place.z), (q.x, q.y, q.z, q.w))
            )  # fmt: skip


class Simulator(UavSimulator):
    """The node, with the topics of tf2 in memory."""

    def create_publisher(self, kind, topic, qos, **options):
        if kind is not TFMessage:
            return super().create_publisher(kind, topic, qos, **options)
        self.tf = {**getattr(self, "tf", {}), topic: Publisher(qos)}
        return self.tf[topic]


@pytest.fixture
def tf2(monkeypatch):
    package, messages = ModuleType("tf2_msgs"), ModuleType("tf2_msgs.msg")
    messages.TFMessage = TFMessage
    monkeypatch.setitem(sys.modules, "tf2_msgs", package)
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", messages)


@pytest.mark.nodes
def test_each_state_is_a_transform_in_the_aircrafts_own_frame(nodes, tf2):
    node, states = nodes.add(Simulator, namespace="/uav1"), []
    node._state_publisher.publisher.publish = states.append
    node._step()
    moving, static = node.tf["/tf"], node.tf["/tf_static"]
    (state,), (transform,) = states, moving.sent
    parent, child, stamp, place, rotation = transform
    assert (parent, child) == ("map", "uav1/base_link")
    assert stamp == nanoseconds(state.header.stamp)
    position, q = state.pose.pose.position, state.pose.pose.orientation
    assert place == (position.x, position.y, position.z)
    assert rotation == (q.x, q.y, q.z, q.w)
    assert [(*each[:2], each[-1]) for each in static.sent] == [
        ("map", "map_ned", NORTH_EAST_DOWN),
        ("uav1/base_link", "uav1/base_link_frd", FORWARD_RIGHT_DOWN),
    ]
    assert static.qos.durability == DurabilityPolicy.TRANSIENT_LOCAL
    assert moving.qos.durability != DurabilityPolicy.TRANSIENT_LOCAL
    assert {moving.qos.reliability, static.qos.reliability} == {ReliabilityPolicy.RELIABLE}
    moving.listeners = 0
    node._step()
    assert len(states) == 2
    assert len(moving.sent) == 1  # nobody listens


@pytest.mark.nodes
def test_tf_can_be_moved_as_with_tf2_itself(nodes, tf2):
    arguments = ["--ros-args", "-r", "/tf:=tf", "-r", "/tf_static:=tf_static"]
    node = nodes.add(Simulator, arguments, "/uav1")
    assert node.resolve_topic_name("/tf") == "/uav1/tf"


@pytest.mark.nodes
@pytest.mark.skipif(importlib.util.find_spec("tf2_msgs") is not None, reason="ROS has tf2_msgs")
def test_without_tf2_msgs_that_is_said_once_and_states_are_published(nodes):
    logger, states = mock.MagicMock(), []

    class Logged(UavSimulator):
        def get_logger(self):
            return logger

    node = nodes.add(Logged)
    node._state_publisher.publisher.publish = states.append
    node._step()
    node._step()
    assert len(states) == 2
    said = [call.args[0] for call in logger.info.call_args_list]
    assert said.count("tf2_msgs is not installed: /tf is not published") == 1
    assert isinstance(states[0], ODOMETRY.type)
