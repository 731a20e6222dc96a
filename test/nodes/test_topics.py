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

"""Frames are parameters: written, expected, checked; two aircraft do not share one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from filled_messages import filled_air, filled_command, filled_odometry, filled_point
from node_harness import callback, tapped
from paced_link import LINK

from uav_tracking_mpc.links import Sighting
from uav_tracking_mpc.nodes.autopilot_link import AutopilotLink
from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    plan_from_command,
    position_from_point,
    target_from_odometry,
)
from uav_tracking_mpc.nodes.messages.named_figures import orbit_from_message, orbit_message
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.target_publisher import TargetPublisher
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ANY_FRAMES,
    COMMAND,
    FRAMES,
    MARKERS,
    ODOMETRY,
    ORBIT,
    PREDICTED_PATH,
    TARGET,
    TARGET_ODOMETRY,
    FrameNames,
    MessageError,
    frame_names,
)
from uav_tracking_mpc.nodes.uav_simulator import UavSimulator
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.frame_parameters import FrameParameters

OTHER = FrameNames("world", "uav1/base_link")


def node_in(namespace):
    return SimpleNamespace(get_namespace=lambda: namespace)


@pytest.mark.parametrize(
    ("namespace", "values", "expected"),
    [
        ("/", {}, ("map", "base_link")),
        ("/uav1", {}, ("map", "uav1/base_link")),
        ("/fleet/uav1", {}, ("map", "fleet/uav1/base_link")),
        ("/uav1", {"frame_prefix": ""}, ("map", "base_link")),
        ("/", {"frame_prefix": "a_"}, ("map", "a_base_link")),
        ("/", {"map_frame": "world", "base_frame": "body"}, ("world", "body")),
    ],
)
def test_the_prefix_is_the_namespace_unless_it_is_told(namespace, values, expected):
    assert frame_names(node_in(namespace), FrameParameters(**values)) == expected


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"map_frame": ""}, "'map_frame' is '', must be a frame"),
        ({"map_frame": "/map"}, "'map_frame' is '/map'.*without a leading slash"),
        ({"base_frame": "base link"}, "'base_frame' is 'base link'.*without blanks"),
        ({"base_frame": "map"}, "'base_frame' is 'map', must be another frame than 'map_frame'"),
        ({"frame_prefix": "/uav"}, "'frame_prefix' is '/uav'"),
    ],
)
def test_names_that_tf2_does_not_take_are_refused(values, words):
    with pytest.raises(ParameterError, match=words):
        frame_names(node_in("/"), FrameParameters(**values))


def messages(frames):
    odometry = filled_odometry(1, [180.0, 0.0, 40.0, 2.0, 0.0, 4.0], frames=frames)
    air, point = filled_air(1, 4.0, frames=frames), filled_point(1, frames=frames)
    command = filled_command(1, np.zeros((2, 3)), frames=frames)
    return odometry, air, point, command, orbit_message(frames), odometry


READERS = (
    lambda message, frames: measurement_from_odometry(message, frames=frames),
    air_velocity_from_twist,
    position_from_point,
    plan_from_command,
    orbit_from_message,
    target_from_odometry,
)


@pytest.mark.parametrize("index", range(len(READERS)))
def test_what_is_written_is_read_and_other_frames_are_refused_in_words(index):
    read, ours, other = READERS[index], messages(FRAMES)[index], messages(OTHER)[index]
    read(ours, FRAMES)
    read(other, OTHER)
    read(ours, ANY_FRAMES)
    read(other, ANY_FRAMES)
    with pytest.raises(MessageError, match=r"(world|uav1/base_link).*must be.*(map|base_link)"):
        read(other, FRAMES)


def keeping(node_class, sent):
    """A kind of node whose messages are kept by topic."""
    return tapped(node_class, lambda topic, message: sent.setdefault(topic, []).append(message))


@pytest.mark.nodes
def test_every_message_of_a_namespaced_aircraft_bears_its_frames(nodes):
    sent, frames = {}, {"map_frame": "world", "namespace": "/uav1"}
    simulator, target, controller = (
        nodes.add(keeping(node_class, sent), **frames)
        for node_class in (UavSimulator, TargetPublisher, NmpcController)
    )

    def pass_on(topic, node):
        callback(node, f"uav1/{topic.name}")(sent[topic.name][-1])

    target._measure()
    pass_on(TARGET, controller)
    for _ in range(3):
        for timer in simulator.timers:
            timer.callback()
        pass_on(AIR_VELOCITY, controller)
        pass_on(ODOMETRY, controller)
    pass_on(COMMAND, simulator)
    pass_on(ORBIT, simulator)
    assert simulator._received == 1
    assert controller.report.refused == simulator._rejected == 0
    odometry, command = sent[ODOMETRY.name][-1], sent[COMMAND.name][-1]
    assert odometry.child_frame_id == sent[AIR_VELOCITY.name][-1].header.frame_id
    assert odometry.child_frame_id == "uav1/base_link"
    assert command.joint_names == ["uav1/base_link"]
    path, markers = sent[PREDICTED_PATH.name][-1], sent[MARKERS.name][-1].markers
    stamped = [odometry, command, sent[TARGET.name][-1], sent[ORBIT.name][-1], path]
    stamped += [*path.poses, *markers]
    assert {message.header.frame_id for message in stamped} == {"world"}


@pytest.mark.nodes
def test_a_link_takes_frames(nodes):
    sent = {}
    frames = {"frame_prefix": "a/", "map_frame": "odom", "namespace": "/uav1"}
    kind, parameters = keeping(AutopilotLink, sent), {"connection": "nobody", "target_system": 2}
    node = nodes.add(kind, link=LINK, **parameters, **frames)
    assert node._frames == ("odom", "a/base_link")
    assert TARGET_ODOMETRY.name not in sent
    node._publish_sighting(1, Sighting(0.0, np.zeros(3), np.ones(3)))
    (track,) = sent[TARGET_ODOMETRY.name]
    assert (track.header.frame_id, track.child_frame_id) == ("odom", "odom")


@pytest.mark.nodes
def test_a_target_is_measured_once_at_each_time(nodes):
    """A timer that is late fires twice before simulated time goes on."""
    sent = {}
    target = nodes.add(keeping(TargetPublisher, sent), use_sim_time=True)
    for _ in range(2):
        target._measure()
    assert len(sent[TARGET.name]) == 1
