"""(9) as printed: (11) but for the bearing."""

from __future__ import annotations

from typing import Any

import casadi as ca

from uav_tracking_mpc.dynamics.relative import RelativeState
from uav_tracking_mpc.dynamics.relative_models.paper import Paper


class Paper9(Paper):
    """(9) as printed: (11) but for the bearing."""

    name = "paper9"

    def rates(self, state: RelativeState, inputs: Any) -> list[Any]:
        """See :meth:`RelativeModel.rates`."""
        r, theta, z, chi, v = state
        rates = super().rates(state, inputs)
        rates[1] = v * r * ca.cos(chi) ** 2 * ca.sin(theta) / (r**2 - z**2) + inputs[0]  # (9b)
        return rates
