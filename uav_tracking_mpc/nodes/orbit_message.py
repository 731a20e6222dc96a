"""The orbit that is flown as a message, ``uav/orbit``, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import JointState

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.nodes.conversions import (
    MAP,
    POSITION_LIMIT,
    SPEED_LIMIT,
    MessageError,
    check_header,
    set_stamp,
)
from uav_tracking_mpc.nodes.topics import ORBIT

NAMES = ["east", "north", "up", "radius", "airspeed"]
LIMITS = np.array([POSITION_LIMIT] * 4 + [SPEED_LIMIT])  # of centre, radius [m] and airspeed [m/s]


def orbit_message() -> JointState:
    """A message to be filled by :func:`set_orbit` again and again."""
    message = JointState(name=NAMES, position=[0.0] * len(NAMES), velocity=[0.0] * len(NAMES))
    message.header.frame_id = MAP
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


def orbit_from_message(message: JointState) -> FlownOrbit:
    """The orbit of a message.

    Args:
        message: As in ``uav/orbit``.

    Raises:
        MessageError: Wrong frame, names or numbers of values, no time, not finite, or absurd.
    """
    check_header(ORBIT.name, message.header, MAP)
    if list(message.name) != NAMES:
        raise MessageError(f"{ORBIT.name}: name is {list(message.name)}, must be {NAMES}")
    position = _checked("position", message.position, LIMITS)
    velocity = _checked("velocity", message.velocity, np.full(len(NAMES), SPEED_LIMIT))
    _, _, _, radius, airspeed = position.tolist()
    return FlownOrbit(position[:3], velocity[:3], radius, airspeed)


def _checked(field: str, values: object, limits: NDArray[np.float64]) -> NDArray[np.float64]:
    numbers = np.array(values, dtype=float)
    if numbers.shape != limits.shape or not (np.abs(numbers) <= limits).all():
        raise MessageError(
            f"{ORBIT.name}: {field} is {numbers.tolist()}, must be {len(NAMES)} finite numbers "
            f"within {limits.tolist()}"
        )
    return numbers
