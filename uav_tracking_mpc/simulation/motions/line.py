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

"""A target that runs straight on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion


class Line(TargetMotion):
    """Runs from ``position`` with ``speed`` towards ``heading``.

    Args:
        parameters: Start, speed and heading.
    """

    name = "line"

    def __init__(self, parameters: TargetParameters) -> None:
        super().__init__(parameters)
        heading = parameters.heading
        self._direction = np.array([np.cos(heading), np.sin(heading), 0.0])

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        return self._start + self.parameters.speed * time * self._direction

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        return self.parameters.speed * self._direction
