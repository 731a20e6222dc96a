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

"""One field of a message gone wrong: types stay, so that it could have come over the wire."""

import numpy as np
import pytest

pytest.importorskip("rclpy")

from hypothesis import given, settings
from hypothesis import strategies as st
from message_strategies import changed
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.messages.conversions import set_command
from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET


def message_of(topic):
    message = topic.type()
    if topic is COMMAND:
        set_command(message, 10**9, np.full((3, 3), 0.1), 0.5)
    return message


@pytest.mark.parametrize("topic", [ODOMETRY, AIR_VELOCITY, TARGET, COMMAND], ids=lambda t: t.name)
@given(data=st.data())
def test_what_comes_out_can_be_sent_and_the_original_stays(topic, data):
    original = message_of(topic)
    message = data.draw(changed(original))
    received = deserialize_message(serialize_message(message), topic.type)
    assert repr(received) == repr(message)
    assert original == message_of(topic)


KINDS = (
    lambda message: np.isnan(message.pose.pose.position.y),
    lambda message: message.header.stamp.sec < 0,
    lambda message: message.header.frame_id == "odom",
    lambda message: not np.isfinite(message.pose.covariance[7]),
    lambda message: message.twist.twist.linear.x == -message_of(ODOMETRY).twist.twist.linear.x,
)


def test_every_kind_of_field_is_reached():
    reached = set()

    @settings(max_examples=1000, derandomize=True, database=None)  # what is drawn is no chance
    @given(changed(message_of(ODOMETRY)))
    def look(message):
        reached.update(kind for kind in KINDS if kind(message))

    look()
    assert reached == set(KINDS)
