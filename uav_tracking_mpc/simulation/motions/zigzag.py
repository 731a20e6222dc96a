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

"""A target that turns by 90 deg on the spot, left and right by turns."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions.line import Line


class Zigzag(Line):
    """Runs like :class:`Line` for ``drive_time``, as long 90 deg to the left of it, and so on."""

    name = "zigzag"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        drive_time = self.parameters.drive_time
        rounds, rest = divmod(time, 2.0 * drive_time)
        east, north, up = super().position(rounds * drive_time + min(rest, drive_time))
        sideways = rounds * drive_time + max(0.0, rest - drive_time)
        d_east, d_north, _ = self.parameters.speed * sideways * self._direction
        return np.array([east - d_north, north + d_east, up])

    def velocity(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.velocity`."""
        east, north, up = super().velocity(time)
        if time % (2.0 * self.parameters.drive_time) < self.parameters.drive_time:
            return np.array([east, north, up])
        return np.array([-north, east, up])
