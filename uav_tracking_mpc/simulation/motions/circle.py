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

"""A target that runs round a circle."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.target import TargetParameters
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
