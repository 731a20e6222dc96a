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

r"""Throttle to specific force and back, for an engine of which a pilot knows a few numbers.

At cruise V_c the trimmed throttle holds the airspeed in level flight, full throttle in a climb of
``w_+``, and no throttle in a sink of ``w_0``; both autopilots are told these numbers. The drag
grows with the square of the airspeed, and with the load factor n = 1 / cos(phi) of a turn by the
number R of TECS_RLL2THR and FW_T_RLL2THR:

.. math::

    u_v + g \sin\chi = \frac{g}{V_c}
        \begin{cases} w_+ \frac{\delta - \delta_t}{1 - \delta_t} & \delta \ge \delta_t \\
                      w_0 \frac{\delta - \delta_t}{\delta_t} & \delta < \delta_t \end{cases}
        - \frac{g w_0}{V_c} \left(\frac{V^2}{V_c^2} - 1\right) - \frac{R}{V_c} (n - 1)

the map from energy rate to throttle of PX4's TECS (``TECSControl::_calcThrottleControlOutput``).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from uav_tracking_mpc.dynamics.gravity import GRAVITY

STEEPEST = math.radians(80.0)  # up to which the load factor grows


class Engine(NamedTuple):
    """An engine with its airframe.

    Attributes:
        cruise: V_c, true, in [m/s].
        trim: Throttle at cruise, from 0 to 1 [-].
        climb_max: ``w_+`` in [m/s].
        sink_idle: ``w_0`` in [m/s].
        load_energy: R in [m^2/s^3].
    """

    cruise: float
    trim: float
    climb_max: float
    sink_idle: float
    load_energy: float

    def force(self, throttle: float, airspeed: float, roll: float) -> float:
        """u_v + g sin(chi) in [m/s^2].

        Args:
            throttle: delta from 0 to 1 [-].
            airspeed: V, true, in [m/s].
            roll: phi in [rad].
        """
        above = min(max(throttle, 0.0), 1.0) - self.trim
        climb = (
            self.climb_max * above / (1.0 - self.trim)
            if above >= 0.0
            else self.sink_idle * above / self.trim
        )
        return GRAVITY / self.cruise * (climb - self._drag(airspeed, roll))

    def throttle(self, force: float, airspeed: float, roll: float) -> float:
        """Throttle from 0 to 1 [-] that gives a force, as nearly as it can.

        Args:
            force: u_v + g sin(chi) in [m/s^2].
            airspeed: V, true, in [m/s].
            roll: phi in [rad].
        """
        climb = force * self.cruise / GRAVITY + self._drag(airspeed, roll)
        share = climb / self.climb_max if climb >= 0.0 else climb / self.sink_idle
        room = 1.0 - self.trim if climb >= 0.0 else self.trim
        return min(max(self.trim + share * room, 0.0), 1.0)

    def _drag(self, airspeed: float, roll: float) -> float:
        """Sink that the drag beyond that of level cruise makes in [m/s]."""
        load = 1.0 / math.cos(min(abs(roll), STEEPEST))
        faster = self.sink_idle * ((airspeed / self.cruise) ** 2 - 1.0)
        return faster + self.load_energy / GRAVITY * (load - 1.0)
