"""The kinematic fixed-wing vehicle, equation (3) of the paper, advanced exactly.

State ``(x, y, z, psi, chi, v)``: position in ``map`` [m], heading and path angle [rad], airspeed
[m/s]. Inputs ``(u_psi, u_chi, u_v)``: rates of heading and path angle [rad/s], acceleration
[m/s^2]. Under held inputs (3) has a closed solution, so nothing is integrated numerically.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.angles import wrap_angle

STATE_NAMES = ("x", "y", "z", "psi", "chi", "v")
INPUT_NAMES = ("u_psi", "u_chi", "u_v")


def advance(state: ArrayLike, inputs: ArrayLike, duration: float) -> NDArray[np.float64]:
    r"""State of (3) after ``duration`` under held inputs, exact to rounding.

    With :math:`\cos\chi\cos\psi = (\cos(\psi+\chi) + \cos(\psi-\chi))/2` and the like, each
    coordinate is a sum of integrals :math:`\int (v + u_v t) e^{i(\alpha + \omega t)} dt`.

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


def air_velocity(psi: Any, chi: Any, v: Any, xp: ModuleType) -> tuple[Any, Any, Any]:
    """Velocity through the air in ``map``: the right side of (3a)-(3c).

    Args:
        psi: Heading in [rad].
        chi: Path angle in [rad].
        v: Airspeed in [m/s].
        xp: ``math`` or ``numpy`` for numbers, ``casadi`` for symbols.

    Returns:
        East, north and up in [m/s].
    """
    level = v * xp.cos(chi)
    return level * xp.cos(psi), level * xp.sin(psi), v * xp.sin(chi)


def velocity(state: ArrayLike) -> NDArray[np.float64]:
    """Velocity through the air in ``map``, shape (3,), in [m/s].

    Args:
        state: (x, y, z, psi, chi, v), shape (6,).
    """
    _, _, _, psi, chi, v = np.asarray(state, dtype=float).tolist()
    return np.array(air_velocity(psi, chi, v, math))
