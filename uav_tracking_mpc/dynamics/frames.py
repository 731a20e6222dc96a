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

r"""Frames, angles and signs (REP-103): the only module that knows them.

World ``map`` is East-North-Up, body ``base_link`` is Forward-Left-Up. The heading psi turns
counter-clockwise from East; the path angle chi is positive when climbing. FLU pitch is positive
nose *down*, hence

.. math:: R = R_z(\psi) R_y(-\chi)

and the pitch rate on the wire is minus the rate of chi. There is no roll: the vehicle is a point
that moves along its own x axis. Angles are wrapped where they enter and where they are subtracted.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY


def wrap_angle(angle: ArrayLike) -> NDArray[np.float64]:
    """Wrap angles to (-pi, pi].

    Angles that already lie there come back bit for bit.

    Args:
        angle: Angle or array of angles in [rad], any shape.

    Returns:
        The same shape (0-d for a scalar), in [rad].
    """
    angle = np.asarray(angle, dtype=float)
    wrapped = np.pi - np.mod(np.pi - angle, 2.0 * np.pi)
    return np.where((angle > -np.pi) & (angle <= np.pi), angle, wrapped)


# -, quaternions (x, y, z, w) of an autopilot's axes by convention: of North-East-Down in
# East-North-Up, where x and y change places, and of Forward-Right-Down in Forward-Left-Up, half a
# turn about x.
NORTH_EAST_DOWN = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
FORWARD_RIGHT_DOWN = (1.0, 0.0, 0.0, 0.0)


def quaternion_from_course(
    heading: Any, path_angle: Any, xp: ModuleType = math
) -> tuple[Any, Any, Any, Any]:
    """Attitude of ``base_link`` in ``map``.

    Args:
        heading: psi in [rad]: number, or array of any shape.
        path_angle: chi in [rad], likewise.
        xp: Module with ``sin`` and ``cos`` of such values: ``math`` or ``numpy``.

    Returns:
        Unit quaternion (x, y, z, w), the order of geometry_msgs, each of the arguments' shape.
    """
    sin_psi, cos_psi = xp.sin(heading / 2.0), xp.cos(heading / 2.0)
    sin_chi, cos_chi = xp.sin(path_angle / 2.0), xp.cos(path_angle / 2.0)
    return (sin_psi * sin_chi, -cos_psi * sin_chi, sin_psi * cos_chi, cos_psi * cos_chi)


def course_from_quaternion(x: float, y: float, z: float, w: float) -> tuple[float, float]:
    """Heading psi and path angle chi of the body's forward axis; roll plays no part.

    Args:
        x: First component of the unit quaternion of ``base_link`` in ``map`` [-].
        y: Second [-].
        z: Third [-].
        w: Its scalar part [-].

    Returns:
        (psi, chi) in [rad]; psi is 0 where the nose points straight up or down.

    Raises:
        ValueError: The quaternion is not finite or its norm is not 1 within 1e-3.
    """
    norm = math.sqrt(x * x + y * y + z * z + w * w)
    if not abs(norm - 1.0) <= 1e-3:
        raise ValueError(f"quaternion (x={x}, y={y}, z={z}, w={w}) has norm {norm:.6g}, must be 1")
    east = 1.0 - 2.0 * (y * y + z * z) / norm**2
    north = 2.0 * (x * y + w * z) / norm**2
    up = 2.0 * (x * z - w * y) / norm**2
    return math.atan2(north, east), math.asin(max(-1.0, min(1.0, up)))


def bank_from_quaternion(x: float, y: float, z: float, w: float) -> float:
    """Bank of the body, right wing down, in [rad].

    Args:
        x: First component of the unit quaternion of ``base_link`` in ``map`` [-].
        y: Second [-].
        z: Third [-].
        w: Its scalar part [-].
    """
    return math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))


def rotation_from_quaternion(x: float, y: float, z: float, w: float) -> NDArray[np.float64]:
    """Rotation matrix, shape (3, 3), from ``base_link`` to ``map``; roll included.

    Args:
        x: First component of the unit quaternion of ``base_link`` in ``map`` [-].
        y: Second [-].
        z: Third [-].
        w: Its scalar part [-].
    """
    s = 2.0 / (x * x + y * y + z * z + w * w)
    return np.array(
        [
            [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
            [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
            [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
        ]
    )


def rotation_from_course(heading: float, path_angle: float) -> NDArray[np.float64]:
    """Rotation matrix, shape (3, 3), from ``base_link`` to ``map``.

    Args:
        heading: psi in [rad].
        path_angle: chi in [rad].
    """
    sin_psi, cos_psi = math.sin(heading), math.cos(heading)
    sin_chi, cos_chi = math.sin(path_angle), math.cos(path_angle)
    return np.array(
        [
            [cos_psi * cos_chi, -sin_psi, -cos_psi * sin_chi],
            [sin_psi * cos_chi, cos_psi, -sin_psi * sin_chi],
            [sin_chi, 0.0, cos_chi],
        ]
    )


def body_rates(path_angle: float, inputs: ArrayLike) -> tuple[float, float, float]:
    """Angular velocity of ``base_link`` in its own axes.

    Args:
        path_angle: chi in [rad].
        inputs: (u_psi, u_chi, u_v), shape (3,), in [rad/s, rad/s, m/s^2].

    Returns:
        Roll, pitch and yaw rate about the body axes in [rad/s].
    """
    turn_rate, path_angle_rate, _ = (float(rate) for rate in np.asarray(inputs))
    return (turn_rate * math.sin(path_angle), -path_angle_rate, turn_rate * math.cos(path_angle))


def course_rates(rotation: NDArray[np.float64], angular: ArrayLike) -> tuple[float, float]:
    """Rates of heading and path angle of the body's forward axis; roll plays no part.

    The inverse of :func:`body_rates`, for any attitude: the forward axis e moves by e' = w x e.

    Args:
        rotation: From ``base_link`` to ``map``, shape (3, 3).
        angular: Angular velocity of ``base_link`` in its own axes, shape (3,), in [rad/s].

    Returns:
        (u_psi, u_chi) in [rad/s]; both 0 where the nose points straight up or down, for the
        heading has no value there.
    """
    # In body axes e = (1, 0, 0), so w x e = (0, w_z, -w_y).
    _, pitch, yaw = np.asarray(angular, dtype=float).tolist()
    axes = rotation.tolist()
    (east, *_), (north, *_), _ = axes
    east_rate, north_rate, up_rate = (yaw * left - pitch * up for _, left, up in axes)
    level = math.hypot(east, north)
    if level < 1e-9:
        return 0.0, 0.0
    return (east * north_rate - north * east_rate) / level**2, up_rate / level


def pitch_rate_from_path_angle_rate(rate: float) -> float:
    """FLU pitch rate on the wire for a path-angle ``rate`` [rad/s], and back: its own inverse."""
    return -rate


def heading_from_yaw(yaw: float) -> float:
    """Heading psi, counter-clockwise from East, of a yaw that turns clockwise from North.

    Args:
        yaw: As autopilots tell it (North-East-Down, Forward-Right-Down) in [rad].

    Returns:
        In [rad], from -pi to pi; the same function leads back.
    """
    return math.remainder(0.5 * math.pi - yaw, 2.0 * math.pi)


def course_rates_from_euler(
    roll: float, pitch: float, body_rates: ArrayLike
) -> tuple[float, float]:
    """Rates of heading and of the nose's elevation from the rates of a Forward-Right-Down body.

    Args:
        roll: Right wing down in [rad].
        pitch: Nose up in [rad], short of straight up or down.
        body_rates: (p, q, r), shape (3,), in [rad/s].

    Returns:
        psi' counter-clockwise, and the elevation's rate, in [rad/s].
    """
    _, q, r = np.asarray(body_rates, dtype=float).tolist()
    yaw_rate = (q * math.sin(roll) + r * math.cos(roll)) / math.cos(pitch)
    return -yaw_rate, q * math.cos(roll) - r * math.sin(roll)


def bank_from_turn_rate(turn_rate: Any, airspeed: Any) -> Any:
    """Bank of a coordinated turn, right wing down positive: tan(bank) = -v psi' / g.

    Lift turns by m v cos(chi) psi' = L sin(bank) and holds the path by m g cos(chi) = L cos(bank).

    Args:
        turn_rate: psi' counter-clockwise in [rad/s]: number, or array of any shape.
        airspeed: v in [m/s], likewise.

    Returns:
        In [rad], between -pi/2 and pi/2, of the shape of the arguments.
    """
    lateral = airspeed * turn_rate
    arc = np.arctan2 if isinstance(lateral, np.ndarray) else math.atan2
    return -arc(lateral, GRAVITY)


def turn_rate_from_bank(bank: float, airspeed: float) -> float:
    """Inverse of :func:`bank_from_turn_rate`, in [rad/s].

    Args:
        bank: Right wing down in [rad], short of the wings' being upright.
        airspeed: v in [m/s], positive.
    """
    return -GRAVITY * math.tan(bank) / airspeed


def quaternion_from_euler(
    roll: float, pitch: float, yaw: float
) -> tuple[float, float, float, float]:
    """Attitude by turns about z, the new y and the newest x.

    In an autopilot's axes yaw is clockwise from North and pitch nose up; of ``base_link`` in
    ``map`` yaw is the heading psi and pitch is nose down, -chi.

    Args:
        roll: Right wing down in [rad].
        pitch: About y in [rad].
        yaw: About z in [rad].

    Returns:
        Unit quaternion (w, x, y, z), the order of MAVLink.
    """
    (sr, cr), (sp, cp), (sy, cy) = (
        (math.sin(0.5 * angle), math.cos(0.5 * angle)) for angle in (roll, pitch, yaw)
    )
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
