"""A target that runs round a circle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions import TargetMotion


class Circle(TargetMotion):
    """Runs with ``speed`` round ``position`` at ``radius``, from the azimuth ``heading`` on."""

    name = "circle"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        azimuth = self._azimuth(time)
        return self._start + self.parameters.radius * np.array(
            [np.cos(azimuth), np.sin(azimuth), 0.0]
        )

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        azimuth = self._azimuth(time)
        return self.parameters.speed * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])

    def _azimuth(self, time: float) -> float:
        return self.parameters.heading + self.parameters.speed * time / self.parameters.radius
