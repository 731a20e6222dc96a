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

r"""Limits of a turn: its rate, its bank, and how quickly the bank may change.

A coordinated turn banks by :math:`\tan\phi = v \omega / g`, so

.. math:: \dot\phi = \frac{(v \dot\omega + \dot v \omega) / g}{1 + (v \omega / g)^2}.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import bank_from_turn_rate, turn_rate_from_bank
from uav_tracking_mpc.dynamics.orbit import sharpest_turn
from uav_tracking_mpc.limits import Bound, Limit, Motion, OrbitShape
from uav_tracking_mpc.parameters.specification import parameter

# -, share of the limit that an orbit may need: one that needs all of the turn rate leaves
# nothing to correct an error with.
TURN_RATE_SHARE = 0.95


@dataclass(frozen=True)
class YawRate(Limit):
    """abs(u_psi) <= yaw_rate_max."""

    name = "yaw_rate"
    hard_on_orbit = True

    yaw_rate_max: float = parameter(
        paper.TURN_RATE_BOUND, "Greatest yaw rate u_psi, either way.", "rad/s", 1e-3, 10.0
    )

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"turn_rate": (None, numbers[0])}

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        turn = sharpest_turn(shape.radius, shape.airspeed, shape.drift)
        return Bound(turn / (TURN_RATE_SHARE * numbers[0]), upper=1.0)


# -, share of the limit that plans use: within a stage, and while commands take effect, the airspeed
# moves on, and the limit of the turn rate with it.
PLANNED_SHARE = 0.98
# s, over which plans let the bank come near its limit: an aircraft whose roll is of second order
# passes a limit towards which it still rolls.
APPROACH_TIME = 0.5
# rad and rad/s, beyond bank or roll rate, of which the square costs one
SCALE = 0.05
LEAST_AIRSPEED = 0.5  # m/s, below which the limit grows no more


@dataclass(frozen=True)
class Bank(Limit):
    """abs(u_psi) <= g tan(bank_max) / v."""

    name = "bank"
    by_squares = True
    hard_on_orbit = True
    of_rates = True

    bank_max: float = parameter(1.4, "Greatest bank angle of a coordinated turn.", "rad", 0.01, 1.5)

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """See :meth:`Limit.numbers`.

        Returns:
            Lateral acceleration of the greatest bank that is planned in [m/s^2], shape (n, 1).
        """
        return np.full((len(targets), 1), PLANNED_SHARE * self.turn_rate_max(1.0))  # v psi'

    def turn_rate_max(self, airspeed: float) -> float:
        """Greatest turn rate in [rad/s]; inf at rest.

        Args:
            airspeed: v in [m/s].
        """
        return turn_rate_from_bank(-self.bank_max, airspeed) if airspeed > 0.0 else math.inf

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"turn_rate": (None, numbers[0] / xp.fmax(motion.airspeed, LEAST_AIRSPEED))}

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound | None:
        """See :meth:`Limit.stage`: where the bank will be soon, if it rolls on as it does.

        None where it is not known how the turn rate changes.
        """
        if motion.turn_acceleration is None:
            return None
        tangent, roll_rate = _rolling(motion)
        most = xp.atan(numbers[0] / GRAVITY)
        return Bound(xp.atan(tangent) + APPROACH_TIME * roll_rate, -most, most, scale=SCALE)

    def orbit(self, shape: OrbitShape, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.orbit`."""
        lateral = sharpest_turn(shape.radius, shape.airspeed, shape.drift) * shape.airspeed
        return Bound(lateral / (TURN_RATE_SHARE * numbers[0]), upper=1.0)

    def flown(self, motion: Motion, numbers: Any) -> Bound:
        """See :meth:`Limit.flown`: the bank of the turn."""
        bank = bank_from_turn_rate(motion.turn_rate, motion.airspeed)
        return Bound(np.abs(bank), upper=self.bank_max)


@dataclass(frozen=True)
class RollRate(Limit):
    """abs(phi') <= roll_rate_max, in plans where each stage begins, since it is greatest there."""

    name = "roll_rate"
    by_squares = True

    roll_rate_max: float = parameter(
        10.0, "Greatest roll rate of plans, with the artificial orbit.", "rad/s", 0.05, 50.0
    )

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound | None:
        """See :meth:`Limit.stage`; None where it is not known how the turn rate changes."""
        if motion.turn_acceleration is None:
            return None
        _, roll_rate = _rolling(motion)
        return Bound(roll_rate, -numbers[0], numbers[0], scale=SCALE)


def _rolling(motion: Motion) -> tuple[Any, Any]:
    """Tangent of the bank, and the roll rate in [rad/s]: the equation above."""
    tangent = motion.airspeed * motion.turn_rate / GRAVITY
    change = motion.airspeed * motion.turn_acceleration + motion.acceleration * motion.turn_rate
    return tangent, change / GRAVITY / (1.0 + tangent**2)
