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

"""Fields of the messages that faults change."""

from __future__ import annotations

from typing import Any

from uav_tracking_mpc.nodes.topics import AIR_VELOCITY, COMMAND, ODOMETRY, TARGET, Topic

LATEST_STAMP = 2**31 - 1  # s, where builtin_interfaces/Time ends

Field = tuple[Any, str]


def numbers(topic: Topic, message: Any) -> list[Field]:
    """Fields that hold what a controller or a vehicle computes with.

    Args:
        topic: Of the message.
        message: With those fields.

    Returns:
        (object that holds the field, name of the field) of each.
    """
    return _NUMBERS[topic.name](message)


def shift(stamp: Any, seconds: float) -> None:
    """Move a stamp, as far as stamps go; those before 0 can be written, but not all can be read.

    Args:
        stamp: builtin_interfaces/Time, changed in place.
        seconds: By how much [s].
    """
    total = stamp.sec * 10**9 + stamp.nanosec + round(seconds * 1e9)
    total = min(max(total, -(2**31) * 10**9), LATEST_STAMP * 10**9)
    stamp.sec, stamp.nanosec = divmod(total, 10**9)


def _axes(vector: Any) -> list[Field]:
    return [(vector, axis) for axis in "xyz"]


def _odometry(message: Any) -> list[Field]:
    pose = message.pose.pose
    return [*_axes(pose.position), (pose.orientation, "w"), *_axes(message.twist.twist.linear)]


def _command(message: Any) -> list[Field]:
    return [
        field
        for point in message.points
        if point.velocities and point.accelerations  # another fault may have emptied them
        for field in (
            (point.velocities[0].angular, "y"),
            (point.velocities[0].angular, "z"),
            (point.accelerations[0].linear, "x"),
        )
    ]


_NUMBERS = {
    ODOMETRY.name: _odometry,
    AIR_VELOCITY.name: lambda message: _axes(message.twist.linear),
    TARGET.name: lambda message: _axes(message.point),
    COMMAND.name: _command,
}
