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

"""A target that is somewhere else at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.simulation.motions.line import Line


class Jump(Line):
    """Runs like :class:`Line` and is moved by ``jump_offset`` at ``jump_time``."""

    name = "jump"

    def position(self, time: float) -> NDArray[np.float64]:
        """See :meth:`TargetMotion.position`."""
        offset = self.parameters.jump_offset if time >= self.parameters.jump_time else 0.0
        return super().position(time) + offset
