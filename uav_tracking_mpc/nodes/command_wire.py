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

"""The command as it goes on the wire, rewritten in place, and read where its numbers stand.

A plan is some twenty points of nested messages; turning them into bytes costs a quarter of a
millisecond on the hot path, and more with cold caches. The bytes of two plans of one length differ
only in numbers whose places do not change, so those are found once and written directly.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message, serialize_message
from trajectory_msgs.msg import MultiDOFJointTrajectoryPoint

from uav_tracking_mpc.control.planned_path import PlannedPath
from uav_tracking_mpc.dynamics.frames import pitch_rate_from_path_angle_rate
from uav_tracking_mpc.nodes.command_path import PLACE, POINT_SIZE, fill_points, set_points
from uav_tracking_mpc.nodes.conversions import nanoseconds, plan_from_command, set_command
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames
from uav_tracking_mpc.nodes.message_checks import POSITION_LIMIT, MessageError
from uav_tracking_mpc.nodes.topics import COMMAND

INPUTS = 3  # (u_psi, u_chi, u_v) of a point
ENCAPSULATION = 4  # bytes before the first field: how the rest is encoded
LITTLE_ENDIAN = 1  # in the second of them
PITCH_SIGN = pitch_rate_from_path_angle_rate(1.0)
STAMP = struct.Struct("<iI")  # header.stamp is the first field
SECOND = 1_000_000_000  # ns
SINGLE_SEGMENT = 1.0  # s that a plan of one segment lasts
UNEVEN = 1e-6  # s by which segments of a plan may differ


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
        self._form: tuple[FrameNames, int, float, bool] | None = None
        self._buffer, self._places = bytearray(), np.zeros((0, 0), dtype=int)
        # Of the command that was read last
        self._same: NDArray[np.uint8] | None = None
        self._step: float | None = None
        self._starts = np.zeros(0)

    def write(
        self, stamp: int, plan: NDArray[np.float64], step: float, path: PlannedPath | None = None
    ) -> bytes:
        """Serialized command, read as the one of :func:`set_command` and :func:`set_points`.

        Args:
            stamp: Time at which the plan begins in [ns].
            plan: (u_psi, u_chi, u_v) at 0, step, 2 step, ..., shape (n, 3), n >= 1.
            step: T_s in [s].
            path: On which the plan leads the aircraft; None leaves it out.
        """
        self._take_form(self._frames, len(plan), step, path is not None)
        values = self._values
        values[:, :INPUTS] = plan
        values[:, 1] *= PITCH_SIGN
        if path is not None:
            fill_points(values[:, INPUTS:], path)
        self._numbers[self._places] = values
        STAMP.pack_into(self._buffer, ENCAPSULATION, *divmod(stamp, SECOND))
        return bytes(self._buffer)

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
        if self._alike(data):
            seconds, rest = STAMP.unpack_from(data, ENCAPSULATION)
            places = self._places[:, :INPUTS]
            plan = np.frombuffer(data, "<f8", len(self._numbers), ENCAPSULATION)[places]
            plan[:, 1] *= PITCH_SIGN
            if rest < SECOND and np.isfinite(plan).all():
                return seconds * SECOND + rest, plan, self._starts
        try:
            message = deserialize_message(data, COMMAND.type)
        except Exception as error:  # whatever the middleware says of bytes that are no message
            raise MessageError(f"{COMMAND.name}: no message: {error}") from error
        plan, self._starts = plan_from_command(message, self._frames)
        self._step, self._same = _step(self._starts), None
        placed = bool(message.points[0].transforms)
        ours = len(message.joint_names) == 1 and all(_ours(p, placed) for p in message.points)
        if self._step is not None and ours:
            named = FrameNames(message.header.frame_id, message.joint_names[0])
            self._take_form(named, len(plan), self._step, placed)
            # Its own bytes, not ours: CDR leaves what stands between aligned fields undefined.
            if len(data) == len(self._buffer):
                self._same = np.frombuffer(data, np.uint8)[self._fixed]
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
        places = self._places[:, INPUTS:][:, PLACE]
        if not (places.size and self._alike(data)):
            return stamp, np.empty((0, 3)), np.empty(0)
        positions = np.frombuffer(data, "<f8", len(self._numbers), ENCAPSULATION)[places]
        if not (np.abs(positions) <= POSITION_LIMIT).all():
            raise MessageError(
                f"{COMMAND.name}: transforms are at {positions.tolist()}, must be finite and "
                f"within {POSITION_LIMIT:g}"
            )
        return stamp, positions, starts

    def _alike(self, data: bytes) -> bool:
        """Whether a command differs from the one that was read last in stamp and numbers alone."""
        if self._same is None or len(data) != len(self._buffer):
            return False
        return np.array_equal(np.frombuffer(data, np.uint8)[self._fixed], self._same)

    def _take_form(self, frames: FrameNames, count: int, step: float, placed: bool) -> None:
        """Find where each number of a plan of another form stands, with its path or without."""
        if self._form == (frames, count, step, placed):
            return
        message = COMMAND.type()
        width = INPUTS + POINT_SIZE * placed
        marks = 1.0 + np.arange(float(width * count)).reshape(count, width)
        set_command(message, 0, marks[:, :INPUTS], step, frames)
        if placed:
            set_points(message, marks[:, INPUTS:])
        buffer = bytearray(serialize_message(message))
        if buffer[1] != LITTLE_ENDIAN:
            raise RuntimeError("commands are not encoded in little-endian CDR")
        size = (len(buffer) - ENCAPSULATION) // 8
        numbers = np.ndarray(size, dtype="<f8", buffer=buffer, offset=ENCAPSULATION)
        marks[:, 1] *= PITCH_SIGN
        order = np.argsort(numbers)
        places = order[np.searchsorted(numbers, marks.ravel(), sorter=order)]
        if not np.array_equal(numbers[places], marks.ravel()):
            raise RuntimeError("a command's numbers are not where they were expected")
        self._buffer, self._numbers = buffer, numbers
        self._places = places.reshape(count, width)
        self._values = np.empty((count, width))
        fixed = np.ones(len(buffer), dtype=bool)
        fixed[ENCAPSULATION : ENCAPSULATION + STAMP.size] = False
        for place in places.tolist():
            begin = ENCAPSULATION + 8 * place
            fixed[begin : begin + 8] = False
        self._fixed = np.flatnonzero(fixed)
        self._same = None
        self._form = frames, count, step, placed


def _ours(point: MultiDOFJointTrajectoryPoint, placed: bool) -> bool:
    """Whether a point has as many parts as ours with their path, or without."""
    parts = len(point.transforms), len(point.velocities), len(point.accelerations)
    return parts == (placed, 1, 1)


def _step(starts: NDArray[np.float64]) -> float | None:
    """Length of the segments in [s]; None where they are not of one length."""
    steps = np.diff(starts)
    step = float(steps[0]) if len(steps) else SINGLE_SEGMENT
    even = step > 0.0 and (len(steps) == 0 or float(np.ptp(steps)) <= UNEVEN)
    return step if even else None
