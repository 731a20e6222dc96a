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

"""Figures by name as messages, and back: the orbit, and what the controller tracks by."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate
from uav_tracking_mpc.dynamics.orbit import FlownOrbit, Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.nodes.messages.conversions import nanoseconds, set_header, set_stamp
from uav_tracking_mpc.nodes.topics import (
    FRAMES,
    ORBIT,
    POSITION_LIMIT,
    SPEED_LIMIT,
    TRACKING_ERRORS,
    FrameNames,
    MessageError,
    check_header,
)

if TYPE_CHECKING:
    from sensor_msgs.msg import JointState

NAMES = ["east", "north", "up", "radius", "airspeed"]
# m, m, m, m, m/s: of centre, radius and airspeed
LIMITS = np.array([POSITION_LIMIT] * 4 + [SPEED_LIMIT])


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
    check_header(ORBIT, message.header, frames.map)
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
            f"{ORBIT.name}: {field} is {numbers.tolist()}, must be {len(NAMES)} finite "
            f"numbers within {limits.tolist()}"
        )
    return numbers


ERRORS = ["range_error", "bearing_error", "altitude_error", "pitch_error", "speed_error"]
TARGET = ["target_east", "target_north", "target_up"]
WIND = ["wind_east", "wind_north", "wind_up"]
TRACKED = [*ERRORS, "bank", *TARGET, "target_std", *WIND, "mode", "airspeed", "surplus"]
MODES = tuple(FallbackMode)  # by the number of "mode"


def tracking_message() -> JointState:
    """A message to be filled by :func:`set_tracking` again and again."""
    from sensor_msgs.msg import JointState

    return JointState(name=TRACKED, position=[0.0] * len(TRACKED))


def set_tracking(
    message: JointState,
    stamp: int,
    situation: Situation,
    orbit: Orbit,
    target_std: float,
    wind: NDArray[np.float64],
    mode: FallbackMode,
    surplus: float,
    frames: FrameNames = FRAMES,
) -> None:
    """Fill a message.

    Args:
        message: Made by :func:`tracking_message`; changed in place.
        stamp: Of the state in [ns].
        situation: At the stamp.
        orbit: What is wanted.
        target_std: Standard deviation of the target's position on each axis in [m].
        wind: As estimated, in ``map``, shape (3,), in [m/s].
        mode: What is flown.
        surplus: What the aircraft turns quicker than its bank says in [rad/s].
        frames: Of the message.
    """
    set_header(message, stamp, frames.map)
    turn_rate, _, _ = situation.rates.tolist()
    figures = [
        *situation.tracking_error(orbit).tolist(),
        bank_from_turn_rate(turn_rate, situation.airspeed),
        *situation.target.tolist(),
        target_std,
        *wind.tolist(),
        float(MODES.index(mode)),
        situation.airspeed,
        surplus,
    ]
    for index, figure in enumerate(figures):
        message.position[index] = figure


def tracking_figures(message: JointState) -> dict[str, float]:
    """The figures of a message by name, in SI units; those that are not finite are left out.

    ``stamp`` is that of the message in [s].

    Args:
        message: As in ``uav/tracking_errors``.

    Raises:
        MessageError: Another number of names than of values.
    """
    if len(message.name) != len(message.position):
        raise MessageError(
            f"{TRACKING_ERRORS.name}: name has {len(message.name)} entries, must have as many "
            f"as position, {len(message.position)}"
        )
    pairs = zip(message.name, message.position, strict=True)
    figures = {name: figure for name, figure in pairs if math.isfinite(figure)}
    return {**figures, "stamp": nanoseconds(message.header.stamp) * 1e-9}


def told_mode(number: float) -> FallbackMode | None:
    """The mode of a number; None where it is none.

    Args:
        number: As of ``mode`` [-].
    """
    return MODES[int(number)] if number in range(len(MODES)) else None
