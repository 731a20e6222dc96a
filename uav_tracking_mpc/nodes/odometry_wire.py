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

"""Odometry as it comes off the wire, read into one message again and again.

Turning the bytes of a message into new objects takes a tenth of a millisecond on the hot path. The
numbers of two messages with the same names of frames stand at the same places, so those are found
once and read directly.
"""

from __future__ import annotations

import struct

import numpy as np
from nav_msgs.msg import Odometry
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.nodes.message_checks import MessageError
from uav_tracking_mpc.nodes.topics import ODOMETRY

LITTLE_ENDIAN = b"\x00\x01"  # CDR, the first of four bytes in front of every message
NAMES = 12  # where the names of the frames begin, behind the stamp
LENGTH = 4  # bytes that tell how long a name is; each begins at a multiple of them
STAMP, STAMP_AT = struct.Struct("<iI"), 4
COVARIANCE = 36  # numbers
NUMBERS = 7 + COVARIANCE + 6 + COVARIANCE  # pose and twist, each with its covariance
POSE, TWIST = struct.Struct("<7d"), struct.Struct("<6d")
TWIST_AT = 8 * (7 + COVARIANCE)  # bytes from the first number
MARKS = 1.0 + np.arange(float(NUMBERS))


class OdometryWire:
    """Reads serialized Odometry messages."""

    def __init__(self) -> None:
        self._message = Odometry()
        # Places of the names of the frames in the messages known, without the gaps behind them:
        # CDR leaves undefined what stands there.
        self._names: tuple[slice, slice] = slice(0), slice(0)
        self._frame = self._child = b""
        self._start = self._size = 0

    def read(self, data: bytes) -> Odometry:
        """The message that bytes are; overwritten by the next call.

        Args:
            data: Serialized.

        Raises:
            MessageError: They are no such message.
        """
        start, (frame, child) = self._start, self._names
        if (
            len(data) != self._size
            or data[frame] != self._frame
            or data[child] != self._child
            or not data.startswith(LITTLE_ENDIAN)
        ):
            return self._read_slowly(data)
        message = self._message
        pose, twist = message.pose, message.twist
        stamp, place, q = message.header.stamp, pose.pose.position, pose.pose.orientation
        linear, angular = twist.twist.linear, twist.twist.angular
        stamp.sec, stamp.nanosec = STAMP.unpack_from(data, STAMP_AT)
        place.x, place.y, place.z, q.x, q.y, q.z, q.w = POSE.unpack_from(data, start)
        (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z) = TWIST.unpack_from(
            data, start + TWIST_AT
        )
        numbers = np.frombuffer(data, "<f8", NUMBERS, start)
        pose.covariance[:] = numbers[7 : 7 + COVARIANCE]
        twist.covariance[:] = numbers[-COVARIANCE:]
        return message

    def _read_slowly(self, data: bytes) -> Odometry:
        try:
            message = deserialize_message(data, ODOMETRY.type)
        except Exception as error:  # whatever the middleware says of bytes that are no message
            raise MessageError(f"{ODOMETRY.name}: no message: {error}") from error
        self._message = message
        self._learn(data, message.header.frame_id, message.child_frame_id)
        return message

    def _learn(self, data: bytes, frame: str, child: str) -> None:
        """Where the numbers stand in a message with these names of frames."""
        marked = Odometry(child_frame_id=child)
        marked.header.frame_id = frame
        pose, twist = marked.pose, marked.twist
        place, q = pose.pose.position, pose.pose.orientation
        place.x, place.y, place.z, q.x, q.y, q.z, q.w = MARKS[:7].tolist()
        pose.covariance[:] = MARKS[7 : 7 + COVARIANCE]
        linear, angular = twist.twist.linear, twist.twist.angular
        (linear.x, linear.y, linear.z, angular.x, angular.y, angular.z) = MARKS[43:49].tolist()
        twist.covariance[:] = MARKS[-COVARIANCE:]
        mine = serialize_message(marked)
        start = len(mine) - MARKS.nbytes
        alike = len(mine) == len(data) and mine.startswith(LITTLE_ENDIAN)
        if alike and mine[start:] == MARKS.tobytes():
            # A name is its length in four bytes, its letters and a zero.
            end = NAMES + LENGTH + len(frame.encode()) + 1
            begin = -(-end // LENGTH) * LENGTH
            names = slice(NAMES, end), slice(begin, begin + LENGTH + len(child.encode()) + 1)
            self._frame, self._child = (data[name] for name in names)
            self._names, self._start, self._size = names, start, len(data)
