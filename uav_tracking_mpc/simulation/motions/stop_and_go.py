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

"""A target that runs straight on, with stops."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions.line import Line


class StopAndGo(Line):
    """Runs like :class:`Line` for ``drive_time``, stands for ``stand_time``, and so on."""

    name = "stop_and_go"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        rounds, rest = divmod(time, self._round)
        driven = rounds * self.parameters.drive_time + min(rest, self.parameters.drive_time)
        return super().position(driven)

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        drives = time % self._round < self.parameters.drive_time
        return super().velocity(time) if drives else np.zeros(3)

    @property
    def _round(self) -> float:
        return self.parameters.drive_time + self.parameters.stand_time
