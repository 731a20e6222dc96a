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

r"""The orbit about a target in a drift: the periodic motion that holds range and airspeed.

Seen from the target the air moves with the drift c, so the aircraft moves with w = a + c where a
is its air velocity, |a| = v. On the circle of radius d, with t its unit tangent and n the normal to
the left of it, w = s t and, with V the horizontal part of v,

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
steady turn. To stay level with the target the path angle makes up for the vertical drift,
:math:`\sin\chi = -c_z / v`.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

# Below this share of V^2 the root is held: the drift then is about as fast as the aircraft, and
# such orbits are refused elsewhere; here it only keeps every iterate finite.
LEAST_ROOT = 0.01
STEEPEST = 0.5  # |c_z| / v beyond which the path angle no longer follows, likewise


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
    """Motion on the orbit of the module's docstring where it crosses an azimuth.

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
