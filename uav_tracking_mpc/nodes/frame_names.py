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

"""The names of the frames as a node writes and expects them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.frame_parameters import NAMESPACE, FrameParameters

if TYPE_CHECKING:
    from rclpy.node import Node


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
