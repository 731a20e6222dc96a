"""A target that visits points in turn, again and again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion


class Waypoints(TargetMotion):
    """Runs with ``speed`` along the chords between ``waypoints``, and from the last to the first.

    Args:
        parameters: Waypoints and speed.
    """

    name = "waypoints"

    def __init__(self, parameters: TargetParameters) -> None:
        super().__init__(parameters)
        corners = np.array(parameters.waypoints).reshape(-1, 3)
        self._corners = np.vstack([corners, corners[:1]])
        lengths = np.linalg.norm(np.diff(self._corners, axis=0), axis=1)
        self._distances = np.concatenate([[0.0], np.cumsum(lengths)])  # of each corner [m]

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        along = self._along(time)
        return np.array([np.interp(along, self._distances, axis) for axis in self._corners.T])

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        segment = int(np.searchsorted(self._distances, self._along(time), side="right")) - 1
        chord = self._corners[segment + 1] - self._corners[segment]
        length = self._distances[segment + 1] - self._distances[segment]
        return self.parameters.speed * chord / length

    def _along(self, time: float) -> float:
        """Distance from the first waypoint along the path in [m]."""
        return float(self.parameters.speed * time % self._distances[-1])
