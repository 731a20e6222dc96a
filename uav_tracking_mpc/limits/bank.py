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

r"""Greatest bank: a coordinated turn banks by :math:`\tan\phi = v u_\psi / g`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.drift import sharpest_turn
from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.limits import Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.limits._turn import TURN_RATE_SHARE
from uav_tracking_mpc.parameters.specification import parameter

# Kept back in plans: within a stage, and while commands take effect, the airspeed moves on, and the
# limit of the turn rate with it.
PLANNED_SHARE = 0.98
LEAST_AIRSPEED = 0.5  # [m/s] below which the limit grows no more


@dataclass(frozen=True)
class Bank(Limit):
    """abs(u_psi) <= g tan(bank_max) / v."""

    name = "bank"
    hard_on_orbit = True
    of_rates = True

    bank_max: float = parameter(1.4, "Greatest bank angle of a coordinated turn.", "rad", 0.01, 1.5)

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """See :meth:`Limit.numbers`.

        Returns:
            Lateral acceleration of the greatest bank that is planned in [m/s^2], shape (n, 1).
        """
        lateral = PLANNED_SHARE * GRAVITY * math.tan(self.bank_max)
        return np.full((len(targets), 1), lateral)

    def turn_rate_max(self, airspeed: float) -> float:
        """Greatest turn rate in [rad/s]; inf at rest.

        Args:
            airspeed: v in [m/s].
        """
        return GRAVITY * math.tan(self.bank_max) / airspeed if airspeed > 0.0 else math.inf

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"turn_rate": (None, numbers[0] / xp.fmax(motion.airspeed, LEAST_AIRSPEED))}

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        lateral = sharpest_turn(shape.radius, shape.airspeed, shape.drift) * shape.airspeed
        return Bound(lateral / (TURN_RATE_SHARE * numbers[0]), upper=1.0)

    def flown(self, motion: Motion, numbers: Any) -> Bound:
        """See :meth:`Limit.flown`: the bank of the turn."""
        bank = np.arctan(motion.airspeed * np.abs(motion.turn_rate) / GRAVITY)
        return Bound(bank, upper=self.bank_max)
