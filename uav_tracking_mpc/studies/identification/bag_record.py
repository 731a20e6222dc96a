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

"""A flight from a rosbag2 bag, MCAP or sqlite; needs no ROS.

A command counts from when it was heard, by the clock of the stamps. Where a bag holds ``/clock``,
that is the newest time heard before it; else bag and stamps must share a clock.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.typesys import Stores, get_typestore

from uav_tracking_mpc.dynamics.frames import (
    course_from_quaternion,
    course_rates,
    pitch_rate_from_path_angle_rate,
    rotation_from_quaternion,
)
from uav_tracking_mpc.studies.identification.channel_record import Samples
from uav_tracking_mpc.studies.identification.flight_record import (
    FlightRecord,
    FlownPlan,
    RecordError,
    flown_demand,
    samples,
)

ODOMETRY, AIR_VELOCITY, COMMAND, CLOCK = "uav/odometry", "uav/air_velocity", "uav/command", "clock"
APART = 10.0  # s by which bag and stamps may differ and still share a clock


class _Contents:
    """Columns, message by message; times in [ns] by the clock of the stamps."""

    def __init__(self) -> None:
        self.plans: list[FlownPlan] = []
        self.states: list[tuple[float, ...]] = []  # time, psi, chi, psi', chi'
        self.airspeeds: list[tuple[float, float]] = []
        self.origin: int | None = None
        self.clock: int | None = None

    def since(self, time: int) -> float:
        """Time since the first stamp in [s]: as floats, whole times would lose nanoseconds."""
        if self.origin is None:
            self.origin = time
        return (time - self.origin) * 1e-9

    def take(self, topic: str, heard: int, message: Any) -> None:
        if topic == CLOCK:
            self.clock = _nanoseconds(message.clock)
            return
        stamp = _nanoseconds(message.header.stamp)
        if topic == ODOMETRY:
            self.states.append((self.since(stamp), *_course(message)))
        elif topic == AIR_VELOCITY:
            linear = message.twist.linear
            speed = float(np.linalg.norm([linear.x, linear.y, linear.z]))
            self.airspeeds.append((self.since(stamp), speed))
        else:
            self._command(stamp, heard if self.clock is None else self.clock, message)

    def _command(self, stamp: int, heard: int, message: Any) -> None:
        late = (heard - stamp) * 1e-9
        if not abs(late) <= APART:
            raise RecordError(
                f"a command was heard {late:.3g} s after its stamp, may be {APART:g} s: bag and "
                "stamps do not share a clock; record /clock with simulated time"
            )
        inputs, starts = [], []
        for point in message.points:
            angular, linear = point.velocities[0].angular, point.accelerations[0].linear
            inputs.append((angular.z, pitch_rate_from_path_angle_rate(angular.y), linear.x))
            starts.append(self.since(stamp + _nanoseconds(point.time_from_start)))
        # A clock that stands between its ticks may be older than the stamp of a state just heard.
        time = self.since(max(heard, stamp))
        self.plans.append(FlownPlan(time, np.array(starts), np.array(inputs)))


def read_bag_record(path: Path) -> FlightRecord:
    """Read a bag.

    Args:
        path: A file ``.mcap``, or the folder of a bag.

    Raises:
        RecordError: It is no bag, or does not hold commands and states.
    """
    contents = _Contents()
    try:
        for topic, heard, message in _messages(path):
            contents.take(topic, heard, message)
    except AnyReaderError as error:
        raise RecordError(f"{path} cannot be read as a bag: {error}") from error
    if not contents.states:
        raise RecordError(f"bag {path} holds no {ODOMETRY}")
    if not contents.plans:
        raise RecordError(f"bag {path} holds no {COMMAND}")
    time, *columns = zip(*contents.states, strict=True)
    heading, path_angle, turn_rate, path_angle_rate = (samples(time, column) for column in columns)
    airspeed: Samples | None = None
    if contents.airspeeds:
        airspeed = samples(*zip(*contents.airspeeds, strict=True))
    return FlightRecord(
        flown_demand(contents.plans), heading, path_angle, airspeed, turn_rate, path_angle_rate
    )


def _messages(path: Path) -> Iterator[tuple[str, int, Any]]:
    """Topic without its namespace, time heard in [ns], and message, in order."""
    typestore = get_typestore(Stores.ROS2_JAZZY)
    with AnyReader([path], default_typestore=typestore) as reader:
        names = {
            connection.id: name
            for connection in reader.connections
            for name in (ODOMETRY, AIR_VELOCITY, COMMAND, CLOCK)
            if f"/{connection.topic.lstrip('/')}".endswith(f"/{name}")
        }
        wanted = [c for c in reader.connections if c.id in names]
        for connection, heard, data in reader.messages(wanted):
            yield names[connection.id], heard, reader.deserialize(data, connection.msgtype)


def _nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def _course(message: Any) -> tuple[float, float, float, float]:
    """(psi, chi, psi', chi') of an Odometry message, in [rad] and [rad/s]."""
    q, angular = message.pose.pose.orientation, message.twist.twist.angular
    heading, path_angle = course_from_quaternion(q.x, q.y, q.z, q.w)
    rotation = rotation_from_quaternion(q.x, q.y, q.z, q.w)
    turn_rate, path_angle_rate = course_rates(rotation, (angular.x, angular.y, angular.z))
    return heading, path_angle, turn_rate, path_angle_rate
