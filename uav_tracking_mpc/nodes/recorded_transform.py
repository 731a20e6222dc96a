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

"""Transforms for ``/tf`` and ``/tf_static`` in a bag, from serialized Odometry messages.

tf2_msgs is not on every machine that records. The seven numbers of a pose and of a transform stand
in the same order on the wire, so the message is put together from the bytes of the other. That also
keeps the recorder quick.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import NamedTuple

from uav_tracking_mpc.dynamics.frames import FORWARD_RIGHT_DOWN, NORTH_EAST_DOWN

TYPE = "tf2_msgs/msg/TFMessage"
LITTLE_ENDIAN = b"\x00\x01\x00\x00"  # of CDR, in front of every message
STAMP = 8  # bytes
POSE = struct.Struct("<7d")  # position and orientation; translation and rotation (x, y, z, w)
LENGTH = struct.Struct("<I")
HERE = (0.0, 0.0, 0.0)  # m, translation to a frame with other axes alone


class RecordedTransform(NamedTuple):
    """A transform in the bytes of the wire.

    Attributes:
        stamp: Seconds and nanoseconds.
        parent: Name of its frame.
        child: Name of the other.
        numbers: Translation in [m] and rotation, a quaternion x, y, z, w.
    """

    stamp: bytes
    parent: bytes
    child: bytes
    numbers: tuple[float, ...]

    def message(self) -> bytes:
        """Serialized message for ``/tf``."""
        return _message([self])

    def statics(self) -> bytes:
        """Serialized message for ``/tf_static``: the frames of autopilots beside these two."""
        return _message(
            RecordedTransform(self.stamp, frame, frame + ending, (*HERE, *rotation))
            for frame, ending, rotation in (
                (self.parent, b"_ned", NORTH_EAST_DOWN),
                (self.child, b"_frd", FORWARD_RIGHT_DOWN),
            )
        )


def recorded_transform(odometry: bytes) -> RecordedTransform | None:
    """The transform that an odometry message says.

    Args:
        odometry: ``nav_msgs/msg/Odometry``, serialized.

    Returns:
        The transform; None if the pose is not finite or the bytes are none of such a message.
    """
    if not odometry.startswith(LITTLE_ENDIAN):
        return None
    body = odometry[len(LITTLE_ENDIAN) :]
    try:
        parent, end = _text(body, STAMP)
        child, end = _text(body, _aligned(end, LENGTH.size))
        numbers = POSE.unpack_from(body, _aligned(end, 8))
    except struct.error:
        return None
    if not all(map(math.isfinite, numbers)):
        return None
    return RecordedTransform(body[:STAMP], parent, child, numbers)


def _message(transforms: Iterable[RecordedTransform]) -> bytes:
    """A sequence: how many, then each; numbers of n bytes begin at multiples of n."""
    parts = list(transforms)
    body = LENGTH.pack(len(parts))
    for transform in parts:
        body = body.ljust(_aligned(len(body), 4), b"\0") + transform.stamp
        for name in (transform.parent, transform.child):
            body = body.ljust(_aligned(len(body), LENGTH.size), b"\0")
            body += LENGTH.pack(len(name) + 1) + name + b"\0"
        body = body.ljust(_aligned(len(body), 8), b"\0") + POSE.pack(*transform.numbers)
    return LITTLE_ENDIAN + body


def _text(body: bytes, start: int) -> tuple[bytes, int]:
    """A text without the zero at its end, and where it ends."""
    (length,) = LENGTH.unpack_from(body, start)
    end = start + LENGTH.size + length
    return body[start + LENGTH.size : end - 1], end


def _aligned(offset: int, size: int) -> int:
    return -(-offset // size) * size
