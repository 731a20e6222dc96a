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

"""Commands and states as bytes: written and read in place.

Two commands of one form differ in stamp and numbers alone: where these stand is learnt once, from
the middleware's own bytes. To write one of 20 points takes 13 us, by objects more than 140: a tenth
of the time from a state to its command.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from geometry_msgs.msg import Transform
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message

from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.dynamics.frames import pitch_rate_from_path_angle_rate, quaternion_from_course
from uav_tracking_mpc.nodes.messages.conversions import (
    nanoseconds,
    plan_from_command,
    set_command,
    set_vector,
)
from uav_tracking_mpc.nodes.topics import (
    COMMAND,
    FRAMES,
    ODOMETRY,
    POSITION_LIMIT,
    FrameNames,
    MessageError,
    Topic,
    finite_vector,
)

ENCAPSULATION = 4  # bytes before the first field: how the rest is encoded
LITTLE_ENDIAN = 1  # code in the second of them
STAMP = struct.Struct("<iI")  # header.stamp is the first field
STATE = struct.Struct("<85d")  # pose, twist and their covariances are the last ones of an odometry
SECOND = 1_000_000_000  # ns
MARKS = 1.25e99, -3.5e-77  # codes: numbers that no other bytes are twice
# Numbers of a point of a command: transform, if it has one, then twist and acceleration.
PLACE, ATTITUDE, VELOCITY = slice(0, 3), slice(3, 7), slice(7, 10)
TRANSFORM, RATES = 7, 12  # how many
INPUTS = [-7, -8, -6]  # indices of (u_psi, u_chi, u_v), from the end
PITCH_SIGN = pitch_rate_from_path_angle_rate(1.0)
SINGLE_SEGMENT = 1.0  # s that a plan of one segment lasts
UNEVEN = 1e-6  # s, tolerance by which segments of a plan may differ


class CommandWire:
    """Writes commands as serialized messages.

    Args:
        frames: Of the messages.
    """

    def __init__(self, frames: FrameNames = FRAMES) -> None:
        self._frames = frames
        self._form: tuple[int, float, bool] | None = None  # points, step, and whether with places

    def write(
        self, stamp: int, plan: NDArray[np.float64], step: float, path: PlannedPath | None = None
    ) -> bytes:
        """Serialized command, read as the one of :func:`set_command`.

        Args:
            stamp: Time at which the plan begins in [ns].
            plan: (u_psi, u_chi, u_v) at 0, step, 2 step, ..., shape (n, 3), n >= 1.
            step: T_s in [s].
            path: On which the plan leads the aircraft; its end is left out, no input belongs to
                it. None leaves out the whole.
        """
        form = len(plan), step, path is not None
        if form != self._form:
            self._learn(*form)
            self._form = form
        values = self._values
        values[:, INPUTS] = plan
        values[:, INPUTS[1]] *= PITCH_SIGN
        if path is not None:
            states = path.states[:-1]
            values[:, PLACE] = states[:, :3]
            quaternions = quaternion_from_course(states[:, 3], states[:, 4], np)
            values[:, ATTITUDE] = np.array(quaternions).T
            values[:, VELOCITY] = path.ground_velocities[:-1]
        _numbers(self._buffer)[self._places] = values.ravel()
        STAMP.pack_into(self._buffer, ENCAPSULATION, *divmod(stamp, SECOND))
        return bytes(self._buffer)

    def _learn(self, count: int, step: float, placed: bool) -> None:
        """Learn where the numbers of commands of a form stand."""
        message = COMMAND.type()
        set_command(message, 0, np.zeros((count, 3)), step, self._frames)
        for point in message.points if placed else ():
            point.transforms = [Transform()]
        self._buffer, other = (
            bytearray(serialize_message(_filled(message, mark))) for mark in MARKS
        )
        if self._buffer[1] != LITTLE_ENDIAN:
            raise RuntimeError("messages are not encoded in little-endian CDR")
        first, second = _numbers(self._buffer), _numbers(other)
        self._places = np.flatnonzero((first == MARKS[0]) & (second == MARKS[1]))
        self._values = np.zeros((count, RATES + TRANSFORM * placed))


def _numbers(data: bytearray) -> NDArray[np.float64]:
    """All places in which a message may have a number, as a view of its bytes."""
    return np.ndarray((len(data) - ENCAPSULATION) // 8, "<f8", data, ENCAPSULATION)


def _filled(message: Any, value: float) -> Any:
    """The message with this value in place of every number."""
    for name in message.get_fields_and_field_types():
        part = getattr(message, name)
        if isinstance(part, float):
            setattr(message, name, value)
        elif isinstance(part, np.ndarray):
            part[:] = value
        for inner in part if isinstance(part, list) else [part]:
            if hasattr(inner, "get_fields_and_field_types"):
                _filled(inner, value)
    return message


def deserialized(topic: Topic, data: bytes) -> Any:
    """The message that bytes are.

    Args:
        topic: From which it came.
        data: Serialized.

    Raises:
        MessageError: They are no such message.
    """
    try:
        return deserialize_message(data, topic.type)
    except Exception as error:  # whatever the middleware says of bytes that are no message
        raise MessageError(f"{topic.name}: no message: {error}") from error


class OdometryWire:
    """Reads states from bytes.

    Those of one sender differ in stamp and numbers alone: what the middleware has made of the first
    one is filled anew, in a tenth of the time.
    """

    def __init__(self) -> None:
        self._form: bytes | None = None  # encoding and frames of the message

    def read(self, data: bytes) -> Any:
        """The message that bytes are: one object, filled anew at each call.

        Args:
            data: Serialized.

        Raises:
            MessageError: They are no such message.
        """
        form = data[:ENCAPSULATION] + data[ENCAPSULATION + STAMP.size : -STATE.size]
        if form != self._form:
            self._message = deserialized(ODOMETRY, data)
            # Its last number must be its end.
            whole = len(serialize_message(self._message)) == len(data)
            self._form = form if whole and form[1] == LITTLE_ENDIAN else None
            return self._message
        numbers = STATE.unpack_from(data, len(data) - STATE.size)
        stamp, pose, twist = self._message.header.stamp, self._message.pose, self._message.twist
        stamp.sec, stamp.nanosec = STAMP.unpack_from(data, ENCAPSULATION)
        place, turned = pose.pose.position, pose.pose.orientation
        place.x, place.y, place.z, turned.x, turned.y, turned.z, turned.w = numbers[:7]
        pose.covariance[:], twist.covariance[:] = numbers[7:43], numbers[49:]
        set_vector(twist.twist.linear, numbers[43:46])
        set_vector(twist.twist.angular, numbers[46:49])
        return self._message


def command_stamp(data: bytes) -> int:
    """Stamp of a serialized command in [ns].

    Args:
        data: In little-endian CDR, as :class:`CommandWire` writes it.
    """
    seconds, rest = STAMP.unpack_from(data, ENCAPSULATION)
    return int(seconds * SECOND + rest)


def command_segments(
    data: bytes, frames: FrameNames = FRAMES
) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Stamp in [ns], plan (u_psi, u_chi, u_v), shape (n, 3), and starts in [s] of a command.

    Args:
        data: Serialized.
        frames: In which it must be.

    Returns:
        The starts, shape (n,), are since the stamp.

    Raises:
        MessageError: As of :func:`plan_from_command`.
    """
    message = deserialized(COMMAND, data)
    return nanoseconds(message.header.stamp), *plan_from_command(message, frames)


def even_command(
    data: bytes, frames: FrameNames = FRAMES
) -> tuple[int, NDArray[np.float64], float]:
    """Stamp in [ns], plan (u_psi, u_chi, u_v), shape (n, 3), and step in [s] of a command.

    Args:
        data: Serialized.
        frames: In which it must be.

    Raises:
        MessageError: As of :func:`command_segments`, or segments that are not of one length.
    """
    stamp, plan, starts = command_segments(data, frames)
    steps = np.diff(starts)
    step = float(steps[0]) if len(steps) else SINGLE_SEGMENT
    if not (step > 0.0 and np.all(np.abs(steps - step) <= UNEVEN)):
        raise MessageError(f"{COMMAND.name}: its segments are not of one length")
    return stamp, plan, step


def planned_places(
    data: bytes, frames: FrameNames = FRAMES
) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
    """Stamp in [ns], planned positions, shape (n, 3), in [m] and times in [s] of a command.

    The times, shape (n,), are since the stamp. In a command without places n is 0.

    Args:
        data: Serialized.
        frames: In which it must be.

    Raises:
        MessageError: As of :func:`plan_from_command`, or a place that is none.
    """
    message = deserialized(COMMAND, data)
    _, starts = plan_from_command(message, frames)
    stamp = nanoseconds(message.header.stamp)
    if not all(point.transforms for point in message.points):
        return stamp, np.empty((0, 3)), np.empty(0)
    places = (point.transforms[0].translation for point in message.points)
    positions = [finite_vector(COMMAND, "transforms", each, POSITION_LIMIT) for each in places]
    return stamp, np.array(positions), starts
