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

"""The kinematic fixed-wing vehicle, equation (3) of the paper, advanced exactly.

Inputs ``(u_psi, u_chi, u_v)``: rates of heading and path angle [rad/s], acceleration [m/s^2].
Under held inputs (3) has a closed solution, so nothing is integrated numerically.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.frames import wrap_angle

INPUT_NAMES = ("u_psi", "u_chi", "u_v")


class VehicleState(NamedTuple):
    """State of (3) by name; an array of shape (6,) in this order is the same state.

    Attributes:
        x: Position East in ``map`` [m].
        y: Position North [m].
        z: Height [m].
        heading: psi, counter-clockwise from East [rad].
        path_angle: chi, positive when climbing [rad].
        airspeed: v [m/s].
    """

    x: Any
    y: Any
    z: Any
    heading: Any
    path_angle: Any
    airspeed: Any


def air_velocity(psi: Any, chi: Any, v: Any, xp: ModuleType) -> tuple[Any, Any, Any]:
    """Velocity through the air in ``map``: the right side of (3a)-(3c), where it stands once.

    Args:
        psi: Heading [rad]: number, array of any shape, or symbol.
        chi: Path angle [rad], likewise.
        v: Airspeed [m/s], likewise.
        xp: Module with ``sin`` and ``cos`` of such values: ``numpy``, ``math`` or ``casadi``.

    Returns:
        (x', y', z') in [m/s], each of the shape of the arguments.
    """
    level = v * xp.cos(chi)
    return level * xp.cos(psi), level * xp.sin(psi), v * xp.sin(chi)


def advance(state: ArrayLike, inputs: ArrayLike, duration: float) -> NDArray[np.float64]:
    r"""State of (3) after ``duration`` under held inputs, exact to rounding.

    With :math:`\cos\chi\cos\psi = (\cos(\psi+\chi) + \cos(\psi-\chi))/2` and the like, each
    coordinate of the integral of :func:`air_velocity` is a sum of
    :math:`\int (v + u_v t) e^{i(\alpha + \omega t)} dt`.

    Args:
        state: (x, y, z, psi, chi, v), shape (6,).
        inputs: (u_psi, u_chi, u_v), shape (3,), held over the interval.
        duration: Length of the interval in [s]; negative runs time backwards.

    Returns:
        State at the end, shape (6,), angles wrapped to (-pi, pi].
    """
    x, y, z, psi, chi, v = (float(value) for value in np.asarray(state))
    u_psi, u_chi, u_v = (float(value) for value in np.asarray(inputs))
    level_sum = _helix(psi + chi, u_psi + u_chi, v, u_v, duration)
    level_difference = _helix(psi - chi, u_psi - u_chi, v, u_v, duration)
    horizontal = 0.5 * (level_sum + level_difference)  # (3a) + i (3b)
    climb = _helix(chi, u_chi, v, u_v, duration).imag  # (3c)
    return np.array(
        [
            x + horizontal.real,
            y + horizontal.imag,
            z + climb,
            wrap_angle(psi + u_psi * duration),
            wrap_angle(chi + u_chi * duration),
            v + u_v * duration,
        ]
    )


def _helix(angle: float, rate: float, speed: float, acceleration: float, time: float) -> complex:
    """Integral over [0, time] of (speed + acceleration t) exp(i (angle + rate t))."""
    turn = 1j * rate * time
    if abs(turn) < 0.5:
        # Truncated series: the closed forms below cancel catastrophically near 0.
        first = second = 0.0 + 0.0j
        term = 1.0 + 0.0j
        for order in range(16):
            first += term / (order + 1)
            second += term / (order + 2)
            term *= turn / (order + 1)
    else:
        exponential = complex(math.cos(rate * time), math.sin(rate * time))
        first = (exponential - 1.0) / turn
        second = (exponential * (turn - 1.0) + 1.0) / turn**2
    direction = complex(math.cos(angle), math.sin(angle))
    return direction * (speed * time * first + acceleration * time**2 * second)


def velocity(state: ArrayLike) -> NDArray[np.float64]:
    """Velocity through the air in ``map``, shape (3,), in [m/s]: see :func:`air_velocity`.

    Args:
        state: (x, y, z, psi, chi, v), shape (6,).
    """
    _, _, _, psi, chi, v = np.asarray(state, dtype=float).tolist()
    # The sine of what is not finite is an error to math, which is ten times as fast.
    return np.array(air_velocity(psi, chi, v, math if math.isfinite(psi + chi) else np))


class Response(NamedTuple):
    """A first-order lag behind a dead time on each of the three channels.

    Attributes:
        lags: Time constants, shape (3,), in [s].
        dead_times: Shape (3,), in [s].
        gains: What is flown over what is commanded, shape (3,) [-].
    """

    lags: NDArray[np.float64]
    dead_times: NDArray[np.float64]
    gains: NDArray[np.float64]


def followed(duration: Any, lag: float) -> Any:
    """Share of a step that a first-order lag has followed after a time [-]; all of it without one.

    Args:
        duration: Since the step in [s]: number, or array of any shape.
        lag: Time constant in [s].

    Returns:
        1 - exp(-t / tau), of the shape of the duration; 1 without a lag.
    """
    if not lag:
        return 1.0
    return -(np.expm1 if isinstance(duration, np.ndarray) else math.expm1)(-duration / lag)
