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

"""What may stand in a message: names of frames, stamps and numbers that can be flown by."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import MeasurementError
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.frame_parameters import NAMESPACE, FrameParameters

if TYPE_CHECKING:
    from geometry_msgs.msg import Point, Vector3
    from rclpy.node import Node
    from std_msgs.msg import Header

POSITION_LIMIT = 1e7  # m; what lies beyond is no position on this earth
SPEED_LIMIT = 1e3  # m/s, no aircraft or target is faster
RATE_LIMIT = 1e2  # rad/s, no aircraft turns faster


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


class FrameNames(NamedTuple):
    """As they stand in messages.

    Attributes:
        map: Of positions: ENU.
        base: Of the aircraft, FLU, with its prefix.
    """

    map: str = "map"
    base: str = "base_link"


FRAMES = FrameNames()  # where nobody says otherwise
ANY_FRAMES = FrameNames("", "")  # for who only looks: messages are read whatever their frames


def frame_names(node: Node, parameters: FrameParameters) -> FrameNames:
    """The names that a node is told.

    Args:
        node: Whose namespace may be the prefix.
        parameters: With ``map_frame``, ``base_frame`` and ``frame_prefix``.

    Raises:
        ParameterError: A name is none that tf2 takes, or both frames are one.
    """
    prefix = parameters.frame_prefix
    if prefix == NAMESPACE:
        namespace = node.get_namespace().strip("/")
        prefix = f"{namespace}/" if namespace else ""
    elif prefix:
        _check("frame_prefix", prefix)
    names = FrameNames(
        map_frame(parameters.map_frame), prefix + _check("base_frame", parameters.base_frame)
    )
    if names.map == names.base:
        raise ParameterError(
            f"parameter 'base_frame' is '{parameters.base_frame}', must be another frame than "
            f"'map_frame' = '{names.map}'"
        )
    return names


def map_frame(name: str) -> str:
    """The name of the frame of positions, checked.

    Args:
        name: As parameter ``map_frame``.

    Raises:
        ParameterError: It is none that tf2 takes.
    """
    return _check("map_frame", name)


def _check(parameter: str, name: str) -> str:
    if not name or name.startswith("/") or any(letter.isspace() for letter in name):
        raise ParameterError(
            f"parameter '{parameter}' is {name!r}, must be a frame: not empty, without a leading "
            "slash and without blanks"
        )
    return name
