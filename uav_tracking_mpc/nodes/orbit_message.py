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

"""The orbit that is flown as a message, ``uav/orbit``, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.nodes.conversions import set_stamp
from uav_tracking_mpc.nodes.frame_names import FRAMES, FrameNames
from uav_tracking_mpc.nodes.message_checks import (
    POSITION_LIMIT,
    SPEED_LIMIT,
    MessageError,
    check_header,
)

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

TOPIC = "uav/orbit"
NAMES = ["east", "north", "up", "radius", "airspeed"]
LIMITS = np.array([POSITION_LIMIT] * 4 + [SPEED_LIMIT])  # of centre, radius [m] and airspeed [m/s]


def orbit_message(frames: FrameNames = FRAMES) -> JointState:
    """A message to be filled by :func:`set_orbit` again and again.

    Args:
        frames: Of the message.
    """
    from sensor_msgs.msg import JointState

    message = JointState(name=NAMES, position=[0.0] * len(NAMES), velocity=[0.0] * len(NAMES))
    message.header.frame_id = frames.map
    return message


def set_orbit(message: JointState, stamp: int, orbit: FlownOrbit) -> None:
    """Fill a message.

    Args:
        message: Made by :func:`orbit_message`; changed in place.
        stamp: Of the command that leads to the orbit, in [ns].
        orbit: What is flown.
    """
    set_stamp(message.header.stamp, stamp)
    position, velocity = message.position, message.velocity
    position[0], position[1], position[2] = orbit.centre.tolist()
    position[3], position[4] = orbit.radius, orbit.airspeed
    velocity[0], velocity[1], velocity[2] = orbit.velocity.tolist()


def orbit_from_message(message: JointState, frames: FrameNames = FRAMES) -> FlownOrbit:
    """The orbit of a message.

    Args:
        message: As in ``uav/orbit``.
        frames: In which it must be.

    Raises:
        MessageError: Wrong frame, names or numbers of values, no time, not finite, or absurd.
    """
    check_header(TOPIC, message.header, frames.map)
    if list(message.name) != NAMES:
        raise MessageError(f"{TOPIC}: name is {list(message.name)}, must be {NAMES}")
    position = _checked("position", message.position, LIMITS)
    velocity = _checked("velocity", message.velocity, np.full(len(NAMES), SPEED_LIMIT))
    _, _, _, radius, airspeed = position.tolist()
    return FlownOrbit(position[:3], velocity[:3], radius, airspeed)


def _checked(field: str, values: object, limits: NDArray[np.float64]) -> NDArray[np.float64]:
    numbers = np.array(values, dtype=float)
    if numbers.shape != limits.shape or not (np.abs(numbers) <= limits).all():
        raise MessageError(
            f"{TOPIC}: {field} is {numbers.tolist()}, must be {len(NAMES)} finite numbers "
            f"within {limits.tolist()}"
        )
    return numbers
