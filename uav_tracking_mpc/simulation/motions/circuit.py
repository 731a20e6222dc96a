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

"""Targets that come round again: a circle, and waypoints."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.simulator import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion


class Circle(TargetMotion):
    """Runs with ``speed`` round ``position`` at ``radius``, from the azimuth ``heading`` on."""

    name = "circle"

    @classmethod
    def starting(
        cls, parameters: TargetParameters, place: NDArray[np.float64], velocity: NDArray[np.float64]
    ) -> TargetParameters:
        """See :meth:`TargetMotion.starting`: the nearest point of the circle."""
        east, north, _ = place - parameters.position
        if east == north == 0.0:  # the centre: every point is as near
            return parameters
        return replace(parameters, heading=math.atan2(north, east))

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


BESIDE = 1e-3  # m, tolerance: a target that is nearer to the path is on it


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

    @classmethod
    def starting(
        cls, parameters: TargetParameters, place: NDArray[np.float64], velocity: NDArray[np.float64]
    ) -> TargetParameters:
        """See :meth:`TargetMotion.starting`: on from a place of the path, else from its start."""
        corners = np.array(parameters.waypoints).reshape(-1, 3)
        for index, corner in enumerate(corners):
            chord = corners[(index + 1) % len(corners)] - corner
            length = float(np.linalg.norm(chord))
            along = float((place - corner) @ chord) / length if length > 0.0 else -1.0
            beside = np.linalg.norm(place - corner - along * chord / max(length, 1e-9))
            if 0.0 <= along < length and beside < BESIDE and velocity @ chord >= 0.0:
                path = np.vstack([place, np.roll(corners, -(index + 1), axis=0)])
                return replace(parameters, waypoints=tuple(path.ravel().tolist()))
        return parameters

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
