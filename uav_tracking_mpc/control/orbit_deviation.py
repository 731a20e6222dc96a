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

r"""Motion near the orbit, linearised at one azimuth.

In a still air the motion relative to the target, seen in axes that turn with the azimuth phi, does
not depend on time. A drift c makes it periodic; frozen at an azimuth it is time-invariant again.
The deviation from the orbit at the same azimuth has the components of :class:`Deviation`. With
:math:`\beta = \psi - \phi` and :math:`V = v \cos\chi`,

.. math::

    \dot d = V \cos\beta + c_r, \quad d \dot\phi = V \sin\beta + c_t, \quad
    \dot z = v \sin\chi + c_z, \quad \dot\beta = \omega_\psi - \dot\phi,

and each rate follows its command with a lag, :math:`\tau \dot\omega = u - \omega`. The deviation
:math:`\delta = x - x^*(\phi)` then moves with :math:`\dot x - (dx^*/d\phi)\,\dot\phi`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.drifting_orbit import orbit_motion
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.symbolic_work import one_at_a_time
from uav_tracking_mpc.estimation.situation import Situation

SLOPE_STEP = 1e-4  # rad of azimuth
COMPLEX_STEP = 1e-20
SHORTEST_LAG = 1e-3  # s: a channel that follows at once is given this lag


class Deviation(NamedTuple):
    """Components of the motion near an orbit, and how far each is moved for a difference.

    Attributes:
        distance: Horizontal, to the target, in [m].
        height: Above the target in [m].
        course: Heading less azimuth in [rad].
        path_angle: chi in [rad].
        airspeed: v in [m/s].
        turn_rate: psi' in [rad/s].
        path_angle_rate: chi' in [rad/s].
        acceleration: v' in [m/s^2].
    """

    distance: float = 0.1
    height: float = 0.05
    course: float = 1e-3
    path_angle: float = 1e-3
    airspeed: float = 0.02
    turn_rate: float = 1e-3
    path_angle_rate: float = 1e-3
    acceleration: float = 0.02


STEPS = np.array(Deviation())
ACCELERATION = Deviation._fields.index("acceleration")
RATES = slice(ACCELERATION - 2, ACCELERATION + 1)
SIZE = len(STEPS)


@dataclass(frozen=True)
class FrozenOrbit:
    """An orbit in a steady drift at one azimuth.

    Attributes:
        orbit: What is flown.
        drift: c in the axes of ``map``, shape (3,), in [m/s].
        azimuth: phi in [rad], direction from target to aircraft.
    """

    orbit: Orbit
    drift: NDArray[np.float64]
    azimuth: float

    @one_at_a_time
    def motion(self, azimuth: float | None = None) -> NDArray[np.float64]:
        """The orbit's own :class:`Deviation` components at an azimuth, shape (8,).

        Args:
            azimuth: In [rad]; that of this object by default.
        """
        phi = self.azimuth if azimuth is None else azimuth
        sense = 1.0 if self.orbit.direction == COUNTER_CLOCKWISE else -1.0
        there = orbit_motion(
            (ca.SX(math.cos(phi)), ca.SX(math.sin(phi))), ca.SX(sense), ca.SX(self.orbit.radius),
            ca.SX(self.orbit.speed), ca.SX(self.drift), ca.SX.zeros(3),
        )  # fmt: skip
        speed, turn_rate = float(there.relative_speed), float(there.turn_rate)
        east, north = (speed * float(part) for part in there.tangent)
        heading = math.atan2(north - self.drift[1], east - self.drift[0])
        course = math.remainder(heading - phi, 2.0 * math.pi)
        radius, height = self.orbit.radius, self.orbit.altitude
        climb = float(there.path_angle)
        return np.array([radius, height, course, climb, self.orbit.speed, turn_rate, 0.0, 0.0])

    def situation(self, deviation: NDArray[np.float64]) -> Situation:
        """Situation at a deviation from the orbit; the target is at the origin of ``map``.

        Args:
            deviation: :class:`Deviation`, shape (8,).
        """
        distance, height, course, climb, speed, *rates = self.motion() + deviation
        x, y = distance * math.cos(self.azimuth), distance * math.sin(self.azimuth)
        vehicle = np.array([x, y, height, course + self.azimuth, climb, speed])
        return Situation(vehicle, np.zeros(3), self.drift, np.zeros(3), np.array(rates))

    def dynamics(self, lags: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """A and B of the deviation's motion, shapes (8, 8) and (8, 3), in SI units.

        Args:
            lags: tau of the three channels, shape (3,), in [s].
        """
        tau = np.maximum(np.asarray(lags, dtype=float), SHORTEST_LAG)
        ahead, behind = (self.azimuth + step for step in (SLOPE_STEP, -SLOPE_STEP))
        slope = (self.motion(ahead) - self.motion(behind)) / (2.0 * SLOPE_STEP)
        cosine, sine = math.cos(self.azimuth), math.sin(self.azimuth)
        c_r = self.drift[0] * cosine + self.drift[1] * sine
        c_t = self.drift[1] * cosine - self.drift[0] * sine

        def rate(state: NDArray[Any]) -> NDArray[Any]:
            d, _, course, climb, v, turn, climbing, gain = state
            level = v * np.cos(climb)
            turning = (level * np.sin(course) + c_t) / d
            rates = np.array([turn, climbing, gain])
            motion = [
                level * np.cos(course) + c_r,
                v * np.sin(climb) + self.drift[2],
                turn - turning, climbing, gain,
            ]  # fmt: skip
            return np.concatenate([motion, -rates / tau]) - slope * turning

        here, b = self.motion(), np.zeros((SIZE, 3))
        b[RATES] = np.diag(1.0 / tau)
        return jacobian(rate, here), b


def jacobian(
    function: Callable[[NDArray[Any]], NDArray[Any]], point: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Derivative of an analytic function by complex steps, shape (m, n).

    Args:
        function: Of shape (n,) to shape (m,).
        point: Where, in its own units, shape (n,).
    """
    columns = [function(point + 1j * COMPLEX_STEP * unit).imag for unit in np.eye(len(point))]
    return np.array(columns).T / COMPLEX_STEP
