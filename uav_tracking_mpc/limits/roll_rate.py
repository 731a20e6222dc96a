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

r"""Greatest roll rate of a coordinated turn.

From :math:`\tan\phi = v \omega / g` follows

.. math:: \dot\phi = \frac{(v \dot\omega + \dot v \omega) / g}{1 + (v \omega / g)^2}.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.limits import Bound, Limit, Motion
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class RollRate(Limit):
    """abs(phi') <= roll_rate_max, in plans as the mean over a stage."""

    name = "roll_rate"
    by_squares = True

    roll_rate_max: float = parameter(
        10.0, "Greatest roll rate of plans, with the artificial orbit.", "rad/s", 0.05, 50.0
    )

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound | None:
        """See :meth:`Limit.stage`; None where it is not known how the turn rate changes."""
        if motion.turn_acceleration is None:
            return None
        tangent = motion.airspeed * motion.turn_rate / GRAVITY
        change = motion.airspeed * motion.turn_acceleration + motion.acceleration * motion.turn_rate
        roll_rate = change / GRAVITY / (1.0 + tangent**2)
        return Bound(roll_rate, -numbers[0], numbers[0], scale=0.15)
