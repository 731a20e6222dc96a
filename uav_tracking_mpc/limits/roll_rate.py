r"""Greatest roll rate of a coordinated turn: :math:`\tan\phi = v \omega / g`, so that

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
