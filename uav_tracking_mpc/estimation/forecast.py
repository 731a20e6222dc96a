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

"""What the horizon will see of target and wind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.situation import Situation


@dataclass(frozen=True)
class Forecast:
    """Target and drift at the stages 0..N of a plan.

    Attributes:
        target: Position in ``map``, shape (N + 1, 3), in [m].
        drift: c, shape (N + 1, 3), in [m/s].
        drift_rate: c', shape (N + 1, 3), in [m/s^2].
        gust_walk: Intensity of level gusts in [m^2/s^3]; infinite where nothing is known of them.
    """

    target: NDArray[np.float64]
    drift: NDArray[np.float64]
    drift_rate: NDArray[np.float64]
    gust_walk: float = 0.0


def steady_forecast(situation: Situation, stages: int) -> Forecast:
    """Present drift and target throughout.

    Args:
        situation: Present target and drift.
        stages: N.
    """
    ahead = (stages + 1, 1)
    return Forecast(
        np.tile(situation.target, ahead), np.tile(situation.drift, ahead), np.zeros((stages + 1, 3))
    )
