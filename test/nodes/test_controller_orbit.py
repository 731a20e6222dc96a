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

"""The controller says which orbit its commands lead to, and hears whether they are flown."""

import numpy as np
import pytest
import rclpy
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message

from uav_tracking_mpc.nodes.conversions import (
    nanoseconds,
    set_air_velocity,
    set_odometry,
    set_point,
)
from uav_tracking_mpc.nodes.nmpc_controller import NmpcController
from uav_tracking_mpc.nodes.orbit_message import orbit_from_message
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ENGAGED, ODOMETRY, ORBIT, TARGET

pytestmark = pytest.mark.nodes
ABOUT = np.array([100.0, 50.0, 3.0])


@pytest.fixture
def controller():
    """The node and what it publishes, in order; the law flies, which needs no compiling."""
    context = rclpy.Context()
    context.init(args=[])
    sent = []

    class Tapped(NmpcController):
        """The node, with a listener on every publisher."""

        def create_publisher(self, kind, topic, *rest, **options):
            publisher = super().create_publisher(kind, topic, *rest, **options)
            publisher.publish = lambda message: sent.append((topic, message))
            return publisher

    node = Tapped(context=context, parameter_overrides=[Parameter("law", value="l1")])
    yield node, sent
    node.finish()
    node.destroy_node()
    context.try_shutdown()


def answered(node, stamp):
    """Tell the node where target and aircraft are."""
    callbacks = {each.topic_name.lstrip("/"): each.callback for each in node.subscriptions}
    seen, state, air = TARGET.type(), ODOMETRY.type(), AIR_VELOCITY.type()
    set_point(seen, stamp, ABOUT)
    set_odometry(state, stamp, np.array([300.0, 50.0, 60.0, 1.6, 0.0, 10.0]), np.zeros(3))
    set_air_velocity(air, stamp, 10.0)
    callbacks[AIR_VELOCITY.name](air)
    callbacks[TARGET.name](seen)
    callbacks[ODOMETRY.name](serialize_message(state))


def test_the_orbit_follows_the_command_with_its_stamp(controller):
    node, sent = controller
    stamp = node.get_clock().now().nanoseconds
    answered(node, stamp)
    topics = [topic for topic, _ in sent]
    assert topics.index(COMMAND.name) + 1 == topics.index(ORBIT.name)
    message = dict(sent)[ORBIT.name]
    orbit, wanted = orbit_from_message(message), node.controller.orbit
    assert nanoseconds(message.header.stamp) == stamp
    above = ABOUT + np.array([0.0, 0.0, wanted.altitude])
    np.testing.assert_allclose(orbit.centre, above, atol=1e-6)
    assert abs(orbit.radius) == pytest.approx(wanted.radius)
    assert orbit.airspeed == wanted.speed


def test_whether_the_commands_are_flown_reaches_the_controller(controller):
    node, _ = controller
    told = []
    node.controller.engage = told.append
    node._on_engaged(ENGAGED.type(data=False))
    node._on_engaged(ENGAGED.type(data=True))
    assert told == [False, True]
