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

"""How the target's position is measured: with noise, not always, and known only later."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.settings.target import TargetParameters
from uav_tracking_mpc.simulation.motions import TargetMotion
from uav_tracking_mpc.simulation.steered_target import SteeredTarget


class TargetSensor:
    """Measures the position of the target and delivers what it measured.

    Noise and dropouts are drawn from their own seeds: a dropout does not change the noise of the
    measurements that arrive.

    Args:
        parameters: Noise, dropouts and delay.
        motion: Of the target.
    """

    def __init__(self, parameters: TargetParameters, motion: TargetMotion | SteeredTarget) -> None:
        self._parameters = parameters
        self._motion = motion
        self._noise = np.random.default_rng(parameters.seed)
        self._dropouts = np.random.default_rng([parameters.seed, 1])
        self._on_the_way: deque[tuple[float, NDArray[np.float64]]] = deque()

    def change(self, parameters: TargetParameters) -> None:
        """Measure with other noise and dropouts from now on.

        Args:
            parameters: All of them; seed and delay stay those of the start.
        """
        self._parameters = parameters

    def measure(self, time: float) -> None:
        """Measure; the result is delivered later.

        Args:
            time: Since the target's start in [s].
        """
        while self._on_the_way and self._on_the_way[-1][0] >= time:
            self._on_the_way.pop()  # the clock went back
        noise = self._parameters.noise * self._noise.standard_normal(3)
        if self._dropouts.random() >= self._parameters.dropout:
            self._on_the_way.append((time, self._motion.position(time) + noise))

    def delivered(self, time: float) -> list[tuple[float, NDArray[np.float64]]]:
        """What has arrived and was not delivered before.

        Args:
            time: Now, since the target's start in [s].

        Returns:
            (time of measuring in [s], position in ``map``, shape (3,), in [m]) of each.
        """
        arrived = []
        while self._on_the_way and (
            self._on_the_way[0][0] + self._parameters.delay <= time + 1e-9  # rounding
        ):
            arrived.append(self._on_the_way.popleft())
        return arrived
