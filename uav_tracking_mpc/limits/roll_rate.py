r"""Greatest roll rate: how quickly the bank, and with it the turn rate, may change.

In a coordinated turn :math:`\tan\phi = v \omega / g`, so that at a held airspeed

.. math:: \dot\phi = \frac{v \dot\omega / g}{1 + (v \omega / g)^2}.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

from uav_tracking_mpc.dynamics.gravity import GRAVITY
from uav_tracking_mpc.limits import Limit, Motion
from uav_tracking_mpc.limits.bank import LEAST_AIRSPEED
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class RollRate(Limit):
    """abs(phi') <= roll_rate_max, as the mean over a stage of a plan."""

    name = "roll_rate"

    roll_rate_max: float = parameter(
        10.0,
        "Greatest roll rate that plans ask for, with the artificial orbit.",
        "rad/s",
        0.05,
        50.0,
    )

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`: the turn rate goes on from where it is."""
        v = xp.fmax(motion.airspeed, LEAST_AIRSPEED)
        tangent = v * motion.turn_rate / GRAVITY
        change = numbers[0] * GRAVITY / v * (1.0 + tangent**2) * motion.rate_reach
        return {"turn_rate": (motion.turn_rate - change, motion.turn_rate + change)}
