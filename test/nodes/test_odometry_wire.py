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

"""Odometry read from bytes is the message that the middleware makes of them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.message_checks import MessageError
from uav_tracking_mpc.nodes.odometry_wire import OdometryWire

numbers = st.floats(allow_nan=True, allow_infinity=True)
names = st.sampled_from(["", "map", "odom", "base_link", "uav1/base_link", "x" * 37])


def odometry(frame, child, sec, nanosec, values):
    message = Odometry(child_frame_id=child)
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    pose, twist = message.pose, message.twist
    p, q = pose.pose.position, pose.pose.orientation
    v, w = twist.twist.linear, twist.twist.angular
    p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z = values[:13]
    pose.covariance[:], twist.covariance[:] = values[13:49], values[49:85]
    return message


def content(message):
    """What a message says; its numbers as bytes, for nan is not itself."""
    stamp, pose, twist = message.header.stamp, message.pose, message.twist
    p, q = pose.pose.position, pose.pose.orientation
    v, w = twist.twist.linear, twist.twist.angular
    values = [p.x, p.y, p.z, q.x, q.y, q.z, q.w, v.x, v.y, v.z, w.x, w.y, w.z]
    values += [*pose.covariance, *twist.covariance]
    names = message.header.frame_id, message.child_frame_id
    return names, stamp.sec, stamp.nanosec, np.array(values).tobytes()


messages = st.builds(
    odometry,
    names,
    names,
    st.integers(-(2**31), 2**31 - 1),
    st.integers(0, 2**32 - 1),
    st.lists(numbers, min_size=85, max_size=85),
)


@given(st.lists(messages, min_size=1, max_size=4))
def test_every_message_reads_as_the_middleware_reads_it(sent):
    wire = OdometryWire()
    for message in [each for each in sent for _ in range(2)]:  # the second time by its places
        data = serialize_message(message)
        assert content(wire.read(data)) == content(deserialize_message(data, Odometry))


def test_after_the_first_message_numbers_are_read_in_place():
    wire, message = OdometryWire(), odometry("map", "base_link", 1, 2, [0.5] * 85)
    data = bytearray(serialize_message(message))
    first = wire.read(bytes(data))
    data[-85 * 8 : -84 * 8], data[-8:] = np.float64(7.0).tobytes(), np.float64(9.0).tobytes()
    data[12 + 4 + 4 + 4 + 10] ^= 0xFF  # behind "base_link": CDR leaves it undefined
    again = wire.read(bytes(data))
    assert again is first
    assert again.pose.pose.position.x == 7.0
    assert again.twist.covariance[35] == 9.0
    message.child_frame_id = "other_link"  # one letter more: the numbers stand elsewhere
    assert wire.read(serialize_message(message)).child_frame_id == "other_link"
    message.child_frame_id = "third_link"  # of the same length: the bytes of the name differ
    assert wire.read(serialize_message(message)).child_frame_id == "third_link"


@pytest.mark.parametrize("data", [b"", b"\x00\x01\x00\x00", b"\x00\x01\x00\x00" + b"\xff" * 60])
def test_what_is_no_message_is_refused_in_words(data):
    wire = OdometryWire()
    with pytest.raises(MessageError, match="uav/odometry: no message"):
        wire.read(data)
    values = list(np.arange(85.0))
    kept = odometry("map", "base_link", 1, 2, values)
    assert wire.read(serialize_message(kept)).pose.pose.position.y == 1.0
    with pytest.raises(MessageError):
        wire.read(data)
