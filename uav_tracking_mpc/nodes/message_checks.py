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

"""What may stand in a message: frames, stamps and numbers that can be flown by."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import MeasurementError

if TYPE_CHECKING:
    from geometry_msgs.msg import Point, Vector3
    from std_msgs.msg import Header

POSITION_LIMIT = 1e7  # m; what lies beyond is no position on this earth
SPEED_LIMIT = 1e3  # m/s
RATE_LIMIT = 1e2  # rad/s


class MessageError(MeasurementError):
    """A message cannot be used; the text names topic, field and value."""


def finite_vector(
    topic: str, name: str, message: Point | Vector3, limit: float
) -> NDArray[np.float64]:
    """A vector of a message, shape (3,), in the unit of the field.

    Args:
        topic: From which it came.
        name: Of the field.
        message: The vector.
        limit: Greatest absolute value of a component, in [m], [m/s] or [rad/s] as the field.

    Raises:
        MessageError: A component is not finite or beyond the limit.
    """
    values = np.array([message.x, message.y, message.z], dtype=float)
    for axis, value in zip("xyz", values, strict=True):
        if not abs(value) <= limit:
            raise MessageError(
                f"{topic}: {name}.{axis} is {value}, must be finite and within {limit:g}"
            )
    return values


def check_header(topic: str, header: Header, frame: str) -> None:
    """Check frame and stamp of a message.

    Args:
        topic: From which it came.
        header: Of the message.
        frame: In which it must be; empty for any.

    Raises:
        MessageError: Another frame, or a stamp that is no time.
    """
    check_frame(topic, "header.frame_id", header.frame_id, frame)
    if header.stamp.nanosec >= 1_000_000_000:  # as a time it could lie past the last one there is
        raise MessageError(
            f"{topic}: header.stamp.nanosec is {header.stamp.nanosec}, must be below 1000000000"
        )


def check_frame(topic: str, name: str, frame: str, expected: str) -> None:
    """Check the name of a frame.

    Args:
        topic: From which it came.
        name: Of the field.
        frame: What stands there.
        expected: What must stand there; empty for any.

    Raises:
        MessageError: Another one.
    """
    if expected and frame != expected:
        raise MessageError(f"{topic}: {name} is '{frame}', must be '{expected}'")
