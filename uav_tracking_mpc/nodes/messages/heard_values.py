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

"""What the messages of an aircraft say to who only looks, live or from a bag; needs no ROS."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.nodes.messages.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    nanoseconds,
    position_from_point,
    target_from_odometry,
    truth_from_odometry,
)
from uav_tracking_mpc.nodes.messages.named_figures import orbit_from_message, tracking_figures
from uav_tracking_mpc.nodes.topics import (
    AIR_VELOCITY,
    ANY_FRAMES,
    DIAGNOSTICS,
    ENGAGED,
    ODOMETRY,
    ORBIT,
    TARGET,
    TARGET_ODOMETRY,
    TARGET_TRUTH,
    TRACKING,
    TRACKING_ERRORS,
    MessageError,
)


def _truth(message: Any) -> NDArray[np.float64]:
    _, position, _ = truth_from_odometry(message)
    if not np.isfinite(position).all():
        raise MessageError(f"{TARGET_TRUTH.name}: position is {position.tolist()}, must be finite")
    return position


class NodeReport(NamedTuple):
    """What a node said of itself.

    Attributes:
        namespace: Of the node, without slashes around it.
        node: Its name.
        level: As of diagnostic_msgs.
        words: What people read.
        values: Keys with units, and figures.
        arrival: When it came, steady, in [s].
    """

    namespace: str
    node: str
    level: int
    words: str
    values: dict[str, str]
    arrival: float = math.nan

    @property
    def path(self) -> str:
        """Its name with its namespace, absolute."""
        return "/" + f"{self.namespace}/{self.node}".strip("/")


def _reports(message: Any) -> list[NodeReport]:
    reports = []
    for status in message.status:
        namespace, _, node = status.name.partition(":")[0].strip("/").rpartition("/")
        level = ord(status.level) if isinstance(status.level, bytes) else int(status.level)
        values = {entry.key: entry.value for entry in status.values}
        reports.append(NodeReport(namespace, node, level, status.message, values))
    return reports


# By topic: from a message to its value in SI units. Each may raise MessageError.
VALUES: dict[str, Callable[[Any], Any]] = {
    ODOMETRY.name: lambda message: measurement_from_odometry(
        message, nanoseconds(message.header.stamp) * 1e-9, ANY_FRAMES
    ),
    AIR_VELOCITY.name: lambda message: math.hypot(*air_velocity_from_twist(message, ANY_FRAMES)),
    TARGET.name: lambda message: position_from_point(message, ANY_FRAMES),
    TARGET_ODOMETRY.name: lambda message: target_from_odometry(message, ANY_FRAMES).position,
    TARGET_TRUTH.name: _truth,
    DIAGNOSTICS.name: _reports,
    ENGAGED.name: lambda message: bool(message.data),
    ORBIT.name: lambda message: orbit_from_message(message, ANY_FRAMES),
    TRACKING_ERRORS.name: tracking_figures,
    TRACKING["cost"].name: lambda message: float(message.data),
    TRACKING["solve_time"].name: lambda message: float(message.data),
}
