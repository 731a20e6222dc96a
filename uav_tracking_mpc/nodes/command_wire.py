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

from uav_tracking_mpc.dynamics.frames import pitch_rate_from_path_angle_rate
from uav_tracking_mpc.nodes.conversions import (
    MessageError,
    nanoseconds,
    plan_from_command,
    set_command,
)
from uav_tracking_mpc.nodes.topics import COMMAND

ENCAPSULATION = 4  # bytes before the first field: how the rest is encoded
LITTLE_ENDIAN = 1  # in the second of them
PITCH_SIGN = pitch_rate_from_path_angle_rate(1.0)
STAMP = struct.Struct("<iI")  # header.stamp is the first field
SECOND = 1_000_000_000  # ns
SINGLE_SEGMENT = 1.0  # s that a plan of one segment lasts
UNEVEN = 1e-6  # s by which segments of a plan may differ


class CommandWire:
    """Writes commands as serialized messages, and reads them."""

    def __init__(self) -> None:
        self._form: tuple[int, float] | None = None
        self._buffer = bytearray()
        self._same: NDArray[np.uint8] | None = None  # of the command that was read last

    def write(self, stamp: int, plan: NDArray[np.float64], step: float) -> bytes:
        """Serialized command, read as the one of :func:`set_command`.

        Args:
            stamp: Time at which the plan begins in [ns].
            plan: (u_psi, u_chi, u_v) at 0, step, 2 step, ..., shape (n, 3), n >= 1.
            step: T_s in [s].
        """
        if self._form != (len(plan), step):
            self._prepare(len(plan), step)
        values = self._values
        values[:] = plan
        values[:, 1] *= PITCH_SIGN
        self._numbers[self._places] = values
        STAMP.pack_into(self._buffer, ENCAPSULATION, *divmod(stamp, SECOND))
        return bytes(self._buffer)

    def read(self, data: bytes) -> tuple[int, NDArray[np.float64], float]:
        """Stamp in [ns], plan (u_psi, u_chi, u_v), shape (n, 3), and step in [s] of a command.

        What differs from the command before in numbers alone is not turned into objects.

        Args:
            data: Serialized.

        Raises:
            MessageError: As of :func:`plan_from_command`, or segments that are not of one length.
        """
        if self._form is not None and self._alike(data):
            seconds, rest = STAMP.unpack_from(data, ENCAPSULATION)
            plan = np.frombuffer(data, "<f8", len(self._numbers), ENCAPSULATION)[self._places]
            plan[:, 1] *= PITCH_SIGN
            if rest < SECOND and np.isfinite(plan).all():
                return seconds * SECOND + rest, plan, self._form[1]
        try:
            message = deserialize_message(data, COMMAND.type)
        except Exception as error:  # whatever the middleware says of bytes that are no message
            raise MessageError(f"{COMMAND.name}: no message: {error}") from error
        plan, starts = plan_from_command(message)
        steps = np.diff(starts)
        step = float(steps[0]) if len(steps) else SINGLE_SEGMENT
        if not step > 0.0 or (len(steps) and np.ptp(steps) > UNEVEN):
            raise MessageError(f"{COMMAND.name}: its segments are not of one length")
        if self._form != (len(plan), step):
            self._prepare(len(plan), step)
        # Its own bytes, not ours: CDR leaves what stands between aligned fields undefined.
        alike = len(data) == len(self._buffer)
        self._same = np.frombuffer(data, np.uint8)[self._fixed] if alike else None
        return nanoseconds(message.header.stamp), plan, step

    def _alike(self, data: bytes) -> bool:
        """Whether a command differs from the one that was read last in stamp and numbers alone."""
        if self._same is None or len(data) != len(self._buffer):
            return False
        return np.array_equal(np.frombuffer(data, np.uint8)[self._fixed], self._same)

    def _prepare(self, count: int, step: float) -> None:
        """Find where each number of a plan of this form stands."""
        message = COMMAND.type()
        marks = 1.0 + np.arange(3.0 * count).reshape(count, 3)
        set_command(message, 0, marks, step)
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
        self._places = places.reshape(count, 3)
        self._values = np.empty((count, 3))
        fixed = np.ones(len(buffer), dtype=bool)
        fixed[ENCAPSULATION : ENCAPSULATION + STAMP.size] = False
        for place in places.tolist():
            begin = ENCAPSULATION + 8 * place
            fixed[begin : begin + 8] = False
        self._fixed = np.flatnonzero(fixed)
        self._same = None
        self._form = count, step
