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

"""What is read of each topic of a recorded aircraft, message by message. Needs no ROS."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_typestore

from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.nodes.conversions import (
    air_velocity_from_twist,
    measurement_from_odometry,
    position_from_point,
)
from uav_tracking_mpc.nodes.frame_names import ANY_FRAMES
from uav_tracking_mpc.nodes.orbit_message import orbit_from_message
from uav_tracking_mpc.nodes.target_odometry import target_from_odometry
from uav_tracking_mpc.nodes.target_truth import truth_from_odometry
from uav_tracking_mpc.nodes.tracking_message import tracking_figures
from uav_tracking_mpc.view.recorded.recorded_statuses import told
from uav_tracking_mpc.view.recorded.recorded_topic import Place, RecordedTopic

KEPT = 4000  # figures
ROOMS = (0, 4, 8, 12)  # bytes
# Not those of nodes.topics: they need ROS.
ODOMETRY, AIR_VELOCITY, COMMAND = "uav/odometry", "uav/air_velocity", "uav/command"
ORBIT, TRACKING_ERRORS = "uav/orbit", "uav/tracking_errors"
COST, SOLVE_TIME = "uav/tracking/cost", "uav/tracking/solve_time"
TARGET, TARGET_ODOMETRY, TARGET_TRUTH = "target/position", "target/odometry", "target/truth"
DIAGNOSTICS = "/diagnostics"


def _motion(message: Any) -> Measurement:
    return measurement_from_odometry(message, frames=ANY_FRAMES)


def _airspeed(message: Any) -> float:
    return math.hypot(*air_velocity_from_twist(message, ANY_FRAMES))


def _number(message: Any) -> float:
    return float(message.data)


def _plan(message: Any) -> NDArray[np.float64] | None:
    """Planned positions, shape (n, 3), in [m]; None where the command holds none."""
    places = [point.transforms[0].translation for point in message.points if point.transforms]
    positions = np.array([(place.x, place.y, place.z) for place in places])
    return positions if len(positions) and np.isfinite(positions).all() else None


class Figure(NamedTuple):
    """What is read of a topic.

    Attributes:
        kind: Type as ROS writes it.
        read: From a message.
    """

    kind: str
    read: Callable[[Any], Any]


FIGURES = {
    ODOMETRY: Figure("nav_msgs/msg/Odometry", _motion),
    AIR_VELOCITY: Figure("geometry_msgs/msg/TwistStamped", _airspeed),
    COMMAND: Figure("trajectory_msgs/msg/MultiDOFJointTrajectory", _plan),
    ORBIT: Figure(
        "sensor_msgs/msg/JointState", lambda message: orbit_from_message(message, ANY_FRAMES)
    ),
    TRACKING_ERRORS: Figure("sensor_msgs/msg/JointState", tracking_figures),
    COST: Figure("std_msgs/msg/Float64", _number),
    SOLVE_TIME: Figure("std_msgs/msg/Float64", _number),
    TARGET: Figure(
        "geometry_msgs/msg/PointStamped", lambda message: position_from_point(message, ANY_FRAMES)
    ),
    TARGET_ODOMETRY: Figure(
        "nav_msgs/msg/Odometry", lambda message: target_from_odometry(message, ANY_FRAMES).position
    ),
    TARGET_TRUTH: Figure("nav_msgs/msg/Odometry", lambda message: truth_from_odometry(message)[1]),
    DIAGNOSTICS: Figure("diagnostic_msgs/msg/DiagnosticArray", told),
}


class RecordedFigures:
    """Reads the topics of one aircraft; what was read last stays in memory.

    Args:
        topics: By their names without the namespace, some of FIGURES.
    """

    def __init__(self, topics: Mapping[str, RecordedTopic]) -> None:
        self.topics = topics
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._room: dict[tuple[str, int], int] = {}  # bytes, by type and size
        self._read: OrderedDict[tuple[str, Place], Any] = OrderedDict()

    def of(self, name: str, place: Place | None) -> Any:
        """What is read of a message; None where there is none or it cannot be used.

        Args:
            name: Of the topic.
            place: Of the message.
        """
        if place is None:
            return None
        key = name, place
        if key in self._read:
            self._read.move_to_end(key)
            return self._read[key]
        figure = FIGURES[name]
        try:
            found = figure.read(self._decoded(self.topics[name].data(place), figure.kind))
        except Exception:  # bytes that are no such message, or numbers that are none
            found = None
        self._read[key] = found
        if len(self._read) > KEPT:
            self._read.popitem(last=False)
        return found

    def _decoded(self, data: bytes, kind: str) -> Any:
        """The message; without the last bytes where it is none with them.

        Fast DDS leaves room for numbers behind each empty sequence of them, which rosbags takes for
        a message of another type.
        """
        known = self._room.get((kind, len(data)), 0)
        for room in (known, *(room for room in ROOMS if room != known)):
            try:
                message = self._store.deserialize_cdr(data[: len(data) - room], kind)
            except Exception:  # whatever it says of such bytes
                continue
            self._room[kind, len(data)] = room
            return message
        raise ValueError(f"{len(data)} bytes are no {kind}")
