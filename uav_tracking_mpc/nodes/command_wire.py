"""The command as it goes on the wire, rewritten in place.

A plan is some twenty points of nested messages; turning them into bytes costs a quarter of a
millisecond on the hot path, and more with cold caches. The bytes of two plans of one length differ
only in numbers whose places do not change, so those are found once and written directly.
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray
from rclpy.serialization import serialize_message

from uav_tracking_mpc.dynamics.frames import pitch_rate_from_path_angle_rate
from uav_tracking_mpc.nodes.conversions import set_command
from uav_tracking_mpc.nodes.topics import COMMAND

ENCAPSULATION = 4  # bytes before the first field: how the rest is encoded
LITTLE_ENDIAN = 1  # in the second of them
PITCH_SIGN = pitch_rate_from_path_angle_rate(1.0)
STAMP = struct.Struct("<iI")  # header.stamp is the first field


class CommandWire:
    """Writes commands as serialized messages."""

    def __init__(self) -> None:
        self._form: tuple[int, float] | None = None

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
        STAMP.pack_into(self._buffer, ENCAPSULATION, *divmod(stamp, 1_000_000_000))
        return bytes(self._buffer)

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
        self._form = count, step
