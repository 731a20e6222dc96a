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

r"""The orbit to fly, a horizontal circle about the target, and what a drift makes of it.

The drift c is the wind less the target's velocity: seen from the target the air moves with c, so
the aircraft moves with w = a + c where a is its air velocity, |a| = v. On the circle of radius d,
with t its unit tangent and n the normal to the left of it, w = s t and, with V the horizontal part
of v,

.. math::

    q = \sqrt{V^2 - |c|^2 + (c \cdot t)^2}, \qquad s = c \cdot t + q.

The bearing of w turns with the azimuth, :math:`\dot\gamma = \sigma s / d` (:math:`\sigma = 1`
counter-clockwise, -1 clockwise), so

.. math::

    \dot w = \dot s\, t + s \dot\gamma\, n, \qquad
    a \cdot (\dot w - \dot c) = 0 \;\Rightarrow\;
    \dot s = (a \cdot \dot c - s \dot\gamma\, a \cdot n) / q, \qquad
    u_\psi = a \times (\dot w - \dot c) / V^2,

which without c' is :math:`\sigma s^2 / (d q)` and without c :math:`\sigma v / d`, the paper's
steady turn. It is sharpest where the tangent is along c. To stay level with the target the path
angle makes up for the vertical drift, :math:`\sin\chi = -c_z / v`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

CLOCKWISE = "clockwise"
COUNTER_CLOCKWISE = "counter_clockwise"
DIRECTIONS = (CLOCKWISE, COUNTER_CLOCKWISE)


@dataclass(frozen=True)
class Orbit:
    """Reference (r_d, z_d, v_d) and direction of the steady turn (Section 3.1, Table 1).

    Attributes:
        range: r_d, distance to the target in [m], greater than ``abs(altitude)``.
        altitude: z_d, height above the target in [m].
        speed: v_d in [m/s], positive.
        direction: ``clockwise`` (theta = +pi/2, u_psi < 0) or ``counter_clockwise``
            (theta = -pi/2, u_psi > 0), seen from above.

    Raises:
        ValueError: A value is not finite or outside the ranges above.
    """

    range: float
    altitude: float
    speed: float
    direction: str = CLOCKWISE

    def __post_init__(self) -> None:
        """Refuse an orbit that is no circle."""
        if not math.isfinite(self.altitude):
            raise ValueError(f"orbit altitude is {self.altitude} m, must be finite")
        if not (math.isfinite(self.range) and self.range > abs(self.altitude)):
            raise ValueError(
                f"orbit range is {self.range} m, must be finite and greater than "
                f"|altitude| = {abs(self.altitude)} m"
            )
        if not (math.isfinite(self.speed) and self.speed > 0.0):
            raise ValueError(f"orbit speed is {self.speed} m/s, must be finite and positive")
        if self.direction not in DIRECTIONS:
            raise ValueError(
                f"orbit direction is {self.direction!r}, must be one of {', '.join(DIRECTIONS)}"
            )

    @property
    def in_short(self) -> str:
        """The numbers in words."""
        return f"{self.range:g} m at {self.altitude:g} m and {self.speed:g} m/s"

    @property
    def radius(self) -> float:
        """Horizontal distance d_d = sqrt(r_d^2 - z_d^2) to the target in [m]."""
        return math.sqrt(self.range**2 - self.altitude**2)

    @property
    def sense(self) -> float:
        """Sign sigma of the turn [-]: 1 counter-clockwise, -1 clockwise."""
        return 1.0 if self.direction == COUNTER_CLOCKWISE else -1.0

    @property
    def bearing(self) -> float:
        """Steady bearing theta_ss in [rad]: +pi/2 clockwise, -pi/2 counter-clockwise."""
        return -self.sense * math.pi / 2.0

    def errors_at(self, x: float, y: float, z: float) -> tuple[float, float]:
        """Errors of range and altitude at (x, y, z) from the target, all in [m]."""
        return math.sqrt(x * x + y * y + z * z) - self.range, z - self.altitude

    @property
    def steady_state(self) -> NDArray[np.float64]:
        """x_ss = (r_d, theta_ss, z_d, 0, v_d), shape (5,), in [m, rad, m, rad, m/s]."""
        return np.array([self.range, self.bearing, self.altitude, 0.0, self.speed])


# -, share of the airspeed that the drift may reach: as fast as that, there is no way back upwind.
DRIFT_SHARE = 0.9


def sharpest_turn(radius: Any, level_speed: Any, drift: Any) -> Any:
    """Greatest turn rate round the orbit in [rad/s], (V + |c|)^2 / (d V); numbers and symbols.

    Args:
        radius: d in [m].
        level_speed: V, the horizontal part of the airspeed, in [m/s].
        drift: abs(c), the drift's horizontal strength, in [m/s].
    """
    return (level_speed + drift) ** 2 / (radius * level_speed)


def horizontal(drift: ArrayLike) -> float:
    """Horizontal strength of a drift in [m/s].

    Args:
        drift: c, shape (3,), in [m/s].
    """
    east, north, _ = (float(value) for value in np.asarray(drift, dtype=float))
    return math.hypot(east, north)


def level_speed(airspeed: float, drift: ArrayLike) -> float:
    """Horizontal airspeed that is left beside the vertical drift, V, in [m/s].

    Args:
        airspeed: v in [m/s].
        drift: c, shape (3,), in [m/s].
    """
    vertical = float(np.asarray(drift, dtype=float)[2])
    return math.sqrt(max(0.0, airspeed * airspeed - vertical * vertical))


# -, share of V^2 below which the root is constant: the drift then is about as fast as the aircraft,
# and such orbits are refused elsewhere; here it only keeps every iterate finite.
LEAST_ROOT = 0.01
STEEPEST = 0.5  # -, share |c_z| / v beyond which the path angle no longer follows, likewise


@dataclass(frozen=True)
class OrbitMotion:
    """Motion on the orbit at one azimuth, as CasADi expressions.

    Attributes:
        tangent: (t_x, t_y), the direction of the relative velocity.
        relative_speed: s in [m/s].
        turn_rate: u_psi in [rad/s].
        turn_acceleration: Its rate along the orbit under a steady drift in [rad/s^2].
        path_angle: chi in [rad].
    """

    tangent: tuple[ca.SX, ca.SX]
    relative_speed: ca.SX
    turn_rate: ca.SX
    turn_acceleration: ca.SX
    path_angle: ca.SX


def orbit_motion(
    radial: tuple[ca.SX, ca.SX],
    sense: ca.SX,
    radius: ca.SX,
    airspeed: ca.SX,
    drift: ca.SX,
    drift_rate: ca.SX,
) -> OrbitMotion:
    """Motion on the orbit in a drift where it crosses an azimuth.

    Args:
        radial: (cos phi, sin phi), the direction from target to aircraft.
        sense: sigma: 1 counter-clockwise, -1 clockwise.
        radius: d in [m].
        airspeed: v in [m/s].
        drift: c, shape (3, 1), in [m/s].
        drift_rate: c', shape (3, 1), in [m/s^2].
    """
    t_x, t_y = -sense * radial[1], sense * radial[0]
    n_x, n_y = -t_y, t_x
    c_t, c_n = drift[0] * t_x + drift[1] * t_y, drift[0] * n_x + drift[1] * n_y
    rate_t = drift_rate[0] * t_x + drift_rate[1] * t_y
    rate_n = drift_rate[0] * n_x + drift_rate[1] * n_y
    level_squared = airspeed**2 - drift[2] ** 2
    q = ca.sqrt(ca.fmax(level_squared - c_n**2, LEAST_ROOT * level_squared))
    s = c_t + q
    azimuth_rate = sense * s / radius
    speed_rate = (q * rate_t - c_n * rate_n + s * azimuth_rate * c_n) / q  # a = q t - c_n n
    turn_rate = (q * (s * azimuth_rate - rate_n) + c_n * (speed_rate - rate_t)) / level_squared
    # d/dt of sigma s^2 / (d q), with (c.t)' = phi' c.n and (c.n)' = -phi' c.t
    along_rate = azimuth_rate * c_n
    root_rate = c_t * along_rate / q
    turn_acceleration = (
        sense / radius * (2.0 * s * (along_rate + root_rate) / q - s**2 * root_rate / q**2)
    )
    sine = ca.fmin(ca.fmax(-drift[2] / airspeed, -STEEPEST), STEEPEST)
    return OrbitMotion((t_x, t_y), s, turn_rate, turn_acceleration, ca.asin(sine))


class FlownOrbit(NamedTuple):
    """A horizontal circle in ``map`` at one time, and how its centre moves.

    Attributes:
        centre: East, north and up in ``map``, shape (3,), in [m]; up is that of the circle itself.
        velocity: Of the centre in ``map``, shape (3,), in [m/s].
        radius: Horizontal, in [m]: positive counter-clockwise, negative clockwise, seen from above.
        airspeed: To hold in [m/s].
        airspeed_now: That is flown at present, as it is estimated, in [m/s]; 0 where nobody tells.
        surplus: What the aircraft turns quicker than its bank says, as it is estimated, in [rad/s].
    """

    centre: NDArray[np.float64]
    velocity: NDArray[np.float64]
    radius: float
    airspeed: float
    airspeed_now: float = 0.0
    surplus: float = 0.0


def orbit_about(
    target: ArrayLike,
    velocity: ArrayLike,
    orbit: Orbit,
    shape: NDArray[np.float64] | None = None,
    airspeed_now: float = 0.0,
    surplus: float = 0.0,
) -> FlownOrbit:
    """The orbit about a target.

    Args:
        target: Position in ``map``, shape (3,), in [m].
        velocity: Of the target in ``map``, shape (3,), in [m/s].
        orbit: What is wanted; its direction counts in any case.
        shape: Range [m], altitude above the target [m] and airspeed [m/s] that are flown in the
            place of the wanted ones, shape (3,).
        airspeed_now: See :class:`FlownOrbit`.
        surplus: Likewise.
    """
    range_, altitude, airspeed = (
        (orbit.range, orbit.altitude, orbit.speed) if shape is None else shape.tolist()
    )
    radius = math.sqrt(max(range_**2 - altitude**2, 0.0))
    return FlownOrbit(
        np.add(target, (0.0, 0.0, altitude)),
        np.array(velocity, dtype=float),
        orbit.sense * radius,
        airspeed,
        airspeed_now,
        surplus,
    )
