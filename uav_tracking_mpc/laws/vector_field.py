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

r"""Lyapunov vector field guidance: a direction for every place, that leads onto the circle.

D. A. Lawrence, E. W. Frew, W. J. Pisano, "Lyapunov Vector Fields for Autonomous UAV Flight
Control", AIAA 2007-6317; E. W. Frew, D. A. Lawrence, S. Morris, "Coordinated Standoff Tracking of
Moving Targets Using Lyapunov Guidance Vector Fields", J. Guidance, Control, and Dynamics 31(2),
2008. At the distance d = rho R and azimuth phi the field points along

.. math:: \chi = \varphi + \sigma (\pi/2 + \gamma), \quad
          \tan\gamma = \frac{\rho^2 - 1}{2 \kappa \rho}

with sigma = 1 counter-clockwise and -1 clockwise: inwards from far away, along the circle on it,
outwards at the centre. kappa = 1 is the field of 2008, a smaller circulation converges faster.
Both papers turn it by the wind; here it is the direction of the velocity *relative to the target*,
from the wind triangle with the drift c and the horizontal air speed V: with h along the field and
n 90 deg to its left,

.. math:: \psi_{des} = \chi - \arcsin(c \cdot n / V)
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import GuidanceLaw, altitude_hold
from uav_tracking_mpc.limits.envelope import Envelope

# -, sine of the steepest crab angle. A stronger cross drift than this leaves no direction of the
# air velocity that follows the field; the aircraft then crabs as it can.
CRAB_MAX = 0.98
FARTHEST = 1e6  # -, times the radius; beyond, the field is as good as radial


class VectorField(GuidanceLaw):
    """Loiter law that turns the relative velocity into a Lyapunov vector field.

    The defaults come from a grid of simulations at 22 m/s on a radius of 275 m, with inner loops of
    0.3 s lag and 0.17 s dead time: least range RMS about a target of 5 m/s in 8 m/s of wind with
    gusts and measurement noise, among those that at most double it when the inner loops are twice
    as slow.

    Args:
        orbit: What to fly.
        envelope: What can be flown.
        circulation: kappa, greater than 0, [-]: share of circling in the field off the circle.
        gain: k in [1/s], turn rate per error of the heading.
    """

    name = "vector_field"

    def __init__(
        self, orbit: Orbit, envelope: Envelope, circulation: float = 0.15, gain: float = 1.1
    ) -> None:
        super().__init__(orbit, envelope)
        self._circulation = circulation
        self._gain = gain

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """See :meth:`GuidanceLaw.inputs`."""
        path_angle, speed = situation.path_angle, situation.airspeed
        wanted, rate = self.heading(situation)
        error = math.remainder(wanted - situation.heading, 2.0 * math.pi)
        turn_rate = rate + self._gain * error
        climb, acceleration = altitude_hold(self.orbit, self.envelope, situation)
        return self.envelope.clip([turn_rate, climb, acceleration], speed, path_angle)

    def heading(self, situation: Situation) -> tuple[float, float]:
        r"""Heading psi_des that follows the field, and its rate along the motion.

        The rate is the exact derivative: with s the relative velocity, q = sqrt(V^2 - (c.n)^2),

        .. math:: \psi_{des}' = \chi' (1 + c \cdot h / q) - (c' \cdot n - (c \cdot n) V' / V) / q

        Args:
            situation: Aircraft, target and drift now.

        Returns:
            (psi_des, psi_des') in [rad, rad/s].
        """
        x, y, _ = situation.offset.tolist()
        wx, wy, _ = situation.relative_velocity.tolist()
        course, course_rate = self._field(x, y, wx, wy)
        cx, cy, _ = situation.drift.tolist()
        cx_rate, cy_rate, _ = situation.drift_rate.tolist()
        _, climb, acceleration = situation.rates.tolist()
        path_angle, speed = situation.path_angle, situation.airspeed
        level = max(abs(speed * math.cos(path_angle)), 0.01 * self.orbit.speed)  # V
        level_rate = acceleration * math.cos(path_angle) - climb * speed * math.sin(path_angle)
        cos, sin = math.cos(course), math.sin(course)
        along, across = cx * cos + cy * sin, cy * cos - cx * sin  # c.h, c.n
        crab = across / level
        if abs(crab) > CRAB_MAX:
            return course - math.copysign(math.asin(CRAB_MAX), crab), course_rate
        q = level * math.sqrt(1.0 - crab * crab)
        across_rate = cy_rate * cos - cx_rate * sin - crab * level_rate
        return course - math.asin(crab), course_rate * (1.0 + along / q) - across_rate / q

    def _field(self, x: float, y: float, wx: float, wy: float) -> tuple[float, float]:
        """Direction of the field at an offset and its rate along a velocity."""
        radius, kappa = self.orbit.radius, self._circulation
        d = math.hypot(x, y)
        rho = min(d / radius, FARTHEST)
        gamma = math.atan2(rho * rho - 1.0, 2.0 * kappa * rho)
        if d > 0.0:
            azimuth, ux, uy = math.atan2(y, x), x / d, y / d
        else:
            # Over the target every direction leads outwards: take that of the flight.
            azimuth = math.atan2(wy, wx)
            ux, uy = math.cos(azimuth), math.sin(azimuth)
        slope = (  # d gamma / d rho
            2.0 * kappa * (rho * rho + 1.0)
            / ((rho * rho - 1.0) ** 2 + (2.0 * kappa * rho) ** 2)
        )  # fmt: skip
        # No aircraft follows the field's turn over the target; the floor keeps it finite.
        azimuth_rate = (ux * wy - uy * wx) / max(d, 1e-3 * radius)
        rate = azimuth_rate + self.sense * slope * (ux * wx + uy * wy) / radius
        return azimuth + self.sense * (math.pi / 2.0 + gamma), rate
