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

r"""L1 loiter: the circle-tracking law that ArduPilot flies, with a target that may move.

The L1 law is S. Park, J. Deyst, J. P. How, "A New Nonlinear Guidance Logic for Trajectory
Tracking", AIAA 2004-4900, with ArduPilot's period and damping (``AP_L1_Control::update_loiter``).
Ground velocity is replaced by the velocity w relative to the target. With e the unit vector
from the target to the aircraft, t 90 deg from it in the sense of the orbit,
omega = 2 pi / T, and an acceleration counted positive towards the inside of the orbit:

.. math::
    a_{circle} = \omega^2 (d - R) + 2 \zeta \omega\, w \cdot e
                 + \frac{(w \cdot t)^2}{\max(d, R / 2)}, \qquad
    a_{capture} = \frac{4 \zeta^2 |w|^2}{L_1} \sin\nu, \quad L_1 = \frac{\zeta T |w|}{\pi}

nu is the angle from w to the target, at most 90 deg. Outside the circle capture flies straight to
the target until the circle asks for less of a turn to the inside.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.laws import GuidanceLaw, altitude_hold
from uav_tracking_mpc.limits.envelope import Envelope


class L1Loiter(GuidanceLaw):
    """Loiter law of ArduPilot about a target.

    The defaults come from a grid of simulations at 22 m/s on a radius of 275 m, with inner loops of
    0.3 s lag and 0.17 s dead time: least range RMS about a target of 5 m/s in 8 m/s of wind with
    gusts and measurement noise, among those that at most double it when the inner loops are twice
    as slow.

    Args:
        orbit: What to fly.
        envelope: What can be flown.
        period: T in [s].
        damping: zeta, [-].
    """

    name = "l1"

    def __init__(
        self, orbit: Orbit, envelope: Envelope, period: float = 8.0, damping: float = 1.2
    ) -> None:
        super().__init__(orbit, envelope)
        self._period = period
        self._damping = damping

    def inputs(self, situation: Situation) -> NDArray[np.float64]:
        """See :meth:`GuidanceLaw.inputs`."""
        path_angle, speed = situation.path_angle, situation.airspeed
        # The bank turns the air velocity: a = v u_psi.
        turn_rate = self.lateral_acceleration(situation) / max(speed, 0.1 * self.orbit.speed)
        climb, acceleration = altitude_hold(self.orbit, self.envelope, situation)
        return self.envelope.clip([turn_rate, climb, acceleration], speed, path_angle)

    def lateral_acceleration(self, situation: Situation) -> float:
        """Acceleration asked for across the velocity in [m/s^2], positive to the left.

        Args:
            situation: Aircraft, target and drift now.
        """
        x, y, _ = situation.offset.tolist()
        wx, wy, _ = situation.relative_velocity.tolist()
        d, speed = math.hypot(x, y), max(math.hypot(wx, wy), 1.0)
        # Over the target, take the direction of the flight for that to the aircraft.
        ex, ey = (x / d, y / d) if d > 0.1 else (wx / speed, wy / speed)
        outward = wx * ex + wy * ey
        around = self.sense * (ex * wy - ey * wx)  # w.t
        radius, omega = self.orbit.radius, 2.0 * math.pi / self._period

        circle = omega * omega * (d - radius) + 2.0 * self._damping * omega * outward
        if outward > 0.0 and around < 0.0:
            circle = max(circle, 0.0)  # the wrong way round and outbound: never turn further out
        circle += around * around / max(d, 0.5 * radius)

        nu = math.atan2(around, -outward)
        nu = min(max(nu, -math.pi / 2.0), math.pi / 2.0)
        distance = self._damping * self._period * speed / math.pi
        capture = 4.0 * self._damping**2 * speed * speed / distance * math.sin(nu)
        if d > radius and capture < circle:
            return self.sense * capture
        return self.sense * circle
