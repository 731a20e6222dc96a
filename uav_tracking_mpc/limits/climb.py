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

"""Limits of a climb: its path angle, and how quickly that may change."""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.limits import Bound, Limit, Motion
from uav_tracking_mpc.parameters.specification import parameter

# rad, -: kept back in plans, but no more than this share of the span: an aircraft that lags more
# than the model comes out of a climb later than planned.
PLANNED_MARGIN, PLANNED_SHARE = 0.03, 0.1
# s, the least time constant with which plans approach a limit: an aircraft whose state is known too
# late does not pass it then.
APPROACH_TIME = 1.0


@dataclass(frozen=True)
class PathAngle(Limit):
    """path_angle_min <= chi <= path_angle_max."""

    name = "path_angle"

    path_angle_min: float = parameter(-1.2, "Steepest descent.", "rad", -1.5, -0.01)
    path_angle_max: float = parameter(1.2, "Steepest climb.", "rad", 0.01, 1.5)

    def numbers(self, targets: NDArray[np.float64]) -> NDArray[np.float64]:
        """See :meth:`Limit.numbers`.

        Returns:
            Steepest planned descent and climb in [rad], shape (n, 2).
        """
        least, most = self.path_angle_min, self.path_angle_max
        margin = min(PLANNED_MARGIN, PLANNED_SHARE * (most - least))
        return np.tile([least + margin, most - margin], (len(targets), 1))

    def stage(self, motion: Motion, numbers: Any, xp: ModuleType) -> Bound:
        """See :meth:`Limit.stage`."""
        return Bound(motion.path_angle, numbers[0], numbers[1], scale=0.1)

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`: the nearer to a limit, the slower towards it."""
        return {
            "path_angle_rate": (
                (numbers[0] - motion.path_angle) / APPROACH_TIME,
                (numbers[1] - motion.path_angle) / APPROACH_TIME,
            )
        }

    def flown(self, motion: Motion, numbers: Any) -> Bound:
        """See :meth:`Limit.flown`: without the margin of plans."""
        return Bound(motion.path_angle, self.path_angle_min, self.path_angle_max)


@dataclass(frozen=True)
class PitchRate(Limit):
    """abs(u_chi) <= pitch_rate_max."""

    name = "pitch_rate"

    pitch_rate_max: float = parameter(
        paper.PATH_ANGLE_RATE_BOUND,
        "Greatest path-angle rate u_chi, either way.",
        "rad/s",
        1e-3,
        10.0,
    )

    def inputs(self, motion: Motion, numbers: Any, xp: ModuleType) -> dict[str, tuple[Any, Any]]:
        """See :meth:`Limit.inputs`."""
        return {"path_angle_rate": (None, numbers[0] + 0.0 * motion.airspeed)}
