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

"""Commands as bytes: written and read in place.

Two commands of one form differ in stamp and numbers alone: where these stand is learnt once, from
the middleware's own bytes. That takes 14 us to write and 8 us to read one of 20 points, by objects
it takes more than 220 and 410 us.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
from geometry_msgs.msg import Transform
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from uav_tracking_mpc.control.commanded_path import PlannedPath
from uav_tracking_mpc.dynamics.frames import pitch_rate_from_path_angle_rate, quaternion_from_course
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, plan_from_command, set_command
from uav_tracking_mpc.nodes.topics import (
    COMMAND,
    FRAMES,
    POSITION_LIMIT,
    FrameNames,
    MessageError,
    Topic,
)

ENCAPSULATION = 4  # bytes before the first field: how the rest is encoded
LITTLE_ENDIAN = 1  # code in the second of them
STAMP = struct.Struct("<iI")  # header.stamp is the first field
BEHIND_STAMP = ENCAPSULATION + STAMP.size
SECOND = 1_000_000_000  # ns
MARKS = 1.25e99, -3.5e-77  # codes: numbers that no other bytes are twice
# Numbers of a point of a command: transform, if it has one, then twist and acceleration.
PLACE, ATTITUDE, VELOCITY = slice(0, 3), slice(3, 7), slice(7, 10)
TRANSFORM, RATES = 7, 12  # how many
READ_IN_PLACE = {(1, 1, 1), (0, 1, 1)}  # parts of a point: ours with their path, or without
INPUTS = [-7, -8, -6]  # indices of (u_psi, u_chi, u_v), from the end
PITCH_SIGN = pitch_rate_from_path_angle_rate(1.0)
SINGLE_SEGMENT = 1.0  # s that a plan of one segment lasts
UNEVEN = 1e-6  # s, tolerance by which segments of a plan may differ


class Form:
    """Where the numbers of a message stand in its bytes, whatever they are.

    Args:
        message: Whose first field is its header, with all parts of the form; all its numbers are
            overwritten.
    """

    def __init__(self, message: Any) -> None:
        self._buffer, other = (
            bytearray(serialize_message(_filled(message, mark))) for mark in MARKS
        )
        if self._buffer[1] != LITTLE_ENDIAN:
            raise RuntimeError("messages are not encoded in little-endian CDR")
        first, second = _doubles(self._buffer), _doubles(other)
        self._places = np.flatnonzero((first == MARKS[0]) & (second == MARKS[1]))
        self._learnt: bytearray | None = None  # a message without stamp and numbers

    def learn(self, data: bytes) -> None:
        """Take note of a message, unless it is encoded in another way.

        Args:
            data: Serialized.
        """
        if len(data) == len(self._buffer) and data[:2] == self._buffer[:2]:
            self._learnt = self._rest(data)

    def _rest(self, data: bytes) -> bytearray:
        """What is neither stamp nor number, with zeros in their places."""
        rest = bytearray(data)
        _doubles(rest)[self._places] = 0.0
        rest[ENCAPSULATION:BEHIND_STAMP] = bytes(STAMP.size)
        return rest

    def fits(self, data: bytes) -> bool:
        """Whether a message differs from the one that was learnt in stamp and numbers alone.

        Args:
            data: Serialized.
        """
        alike = self._learnt is not None and len(data) == len(self._learnt)
        return alike and self._rest(data) == self._learnt

    def numbers(self, data: bytes) -> NDArray[np.float64]:
        """The numbers of a message in order, shape (n,).

        Args:
            data: Serialized; it fits.
        """
        return _doubles(data)[self._places]

    def write(self, stamp: int, numbers: NDArray[np.float64]) -> bytes:
        """Serialized message.

        Args:
            stamp: In [ns].
            numbers: In order, shape (n,) or of as many rows as there are points.
        """
        _doubles(self._buffer)[self._places] = numbers.ravel()
        STAMP.pack_into(self._buffer, ENCAPSULATION, *divmod(stamp, SECOND))
        return bytes(self._buffer)


def _doubles(data: bytes | bytearray) -> NDArray[np.float64]:
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


def command_stamp(data: bytes) -> int:
    """Stamp of a serialized command in [ns].

    Args:
        data: In little-endian CDR, as :class:`CommandWire` writes it.
    """
    seconds, rest = STAMP.unpack_from(data, ENCAPSULATION)
    return int(seconds * SECOND + rest)


class CommandWire:
    """Writes commands as serialized messages, and reads them.

    Args:
        frames: Of the messages, and in which they must be.
    """

    def __init__(self, frames: FrameNames = FRAMES) -> None:
        self._frames = frames
        self._written: tuple[int, float, bool] | None = None  # form of the last one: see write
        # Of the command that was read last
        self._read: Form | None = None
        self._step: float | None = None
        self._starts = np.zeros(0)

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
        if self._written != (form := (len(plan), step, path is not None)):
            message = COMMAND.type()
            set_command(message, 0, np.zeros((len(plan), 3)), step, self._frames)
            for point in message.points if path is not None else ():
                point.transforms = [Transform()]
            self._form = Form(message)
            self._values = np.zeros((len(plan), RATES + TRANSFORM * (path is not None)))
            self._written = form
        values = self._values
        values[:, INPUTS] = plan
        values[:, INPUTS[1]] *= PITCH_SIGN
        if path is not None:
            states = path.states[:-1]
            values[:, PLACE] = states[:, :3]
            quaternions = quaternion_from_course(states[:, 3], states[:, 4], np)
            values[:, ATTITUDE] = np.column_stack(quaternions)
            values[:, VELOCITY] = path.ground_velocities[:-1]
        return self._form.write(stamp, values)

    def read(self, data: bytes) -> tuple[int, NDArray[np.float64], float]:
        """Stamp in [ns], plan (u_psi, u_chi, u_v), shape (n, 3), and step in [s] of a command.

        Args:
            data: Serialized.

        Raises:
            MessageError: As of :meth:`segments`, or segments that are not of one length.
        """
        stamp, plan, _ = self.segments(data)
        if self._step is None:
            raise MessageError(f"{COMMAND.name}: its segments are not of one length")
        return stamp, plan, self._step

    def segments(self, data: bytes) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
        """Stamp in [ns], plan (u_psi, u_chi, u_v), shape (n, 3), and starts in [s] of a command.

        The starts, shape (n,), are since the stamp. What differs from the command before in numbers
        alone is not turned into objects.

        Args:
            data: Serialized.

        Raises:
            MessageError: As of :func:`plan_from_command`.
        """
        if (points := self._points(data)) is not None:
            seconds, rest = STAMP.unpack_from(data, ENCAPSULATION)
            plan = points[:, INPUTS]
            plan[:, 1] *= PITCH_SIGN
            if rest < SECOND and np.isfinite(plan).all():
                return seconds * SECOND + rest, plan, self._starts
        message = deserialized(COMMAND, data)
        plan, self._starts = plan_from_command(message, self._frames)
        self._step = _step(self._starts)
        forms = {_parts(point) for point in message.points}
        self._read = None
        if self._step is not None and len(forms) == 1 and forms <= READ_IN_PLACE:
            self._read = Form(message)
            self._read.learn(data)
        return nanoseconds(message.header.stamp), plan, self._starts

    def places(self, data: bytes) -> tuple[int, NDArray[np.float64], NDArray[np.float64]]:
        """Stamp in [ns], planned positions, shape (n, 3), in [m] and times in [s] of a command.

        The times, shape (n,), are since the stamp. In a command without places, or with segments
        that are not of one length, n is 0.

        Args:
            data: Serialized.

        Raises:
            MessageError: As of :meth:`segments`, or a place that is none.
        """
        stamp, _, starts = self.segments(data)
        points = self._points(data)
        if points is None or points.shape[1] == RATES:
            return stamp, np.empty((0, 3)), np.empty(0)
        positions = points[:, PLACE]
        if not (np.abs(positions) <= POSITION_LIMIT).all():
            raise MessageError(
                f"{COMMAND.name}: transforms are at {positions.tolist()}, must be finite and "
                f"within {POSITION_LIMIT:g}"
            )
        return stamp, positions, starts

    def _points(self, data: bytes) -> NDArray[np.float64] | None:
        """Numbers of each point of a command that is as the one that was read last, else None."""
        if self._read is None or not self._read.fits(data):
            return None
        return self._read.numbers(data).reshape(len(self._starts), -1)


def _parts(point: MultiDOFJointTrajectoryPoint) -> tuple[int, int, int]:
    """How many transforms, velocities and accelerations a point has."""
    return len(point.transforms), len(point.velocities), len(point.accelerations)


def _step(starts: NDArray[np.float64]) -> float | None:
    """Length of the segments in [s]; None where they are not of one length."""
    steps = np.diff(starts)
    step = float(steps[0]) if len(steps) else SINGLE_SEGMENT
    even = step > 0.0 and (len(steps) == 0 or float(np.ptp(steps)) <= UNEVEN)
    return step if even else None
