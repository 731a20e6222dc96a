"""A target that stands."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions import TargetMotion


class Stationary(TargetMotion):
    """Stands at ``position``."""

    name = "stationary"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        return self._start.copy()

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        return np.zeros(3)
