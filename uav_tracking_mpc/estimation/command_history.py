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

"""Commands that were sent, as the aircraft flies them: from when they come on, segment by segment.

A plan's segments are laid out from the stamp of the state that it answers, but the aircraft flies
the plan before it until the new one has been sent.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray


class CommandHistory:
    """Plans by the time at which they were sent.

    Args:
        memory: How long a plan is kept after another has replaced it, in [s].
    """

    def __init__(self, memory: float) -> None:
        self.memory = memory
        # When each was sent and begins, its inputs and its step. The numbers of a list are read ten
        # times as fast as those of an array.
        self._plans: deque[tuple[float, float, list[list[float]], float]] = deque()

    def reset(self) -> None:
        """Forget every command."""
        self._plans.clear()

    def add(self, sent: float, begin: float, inputs: NDArray[np.float64], step: float) -> None:
        """Record a plan that takes effect when it is sent.

        Args:
            sent: From when on it is flown in [s].
            begin: When its first segment begins in [s], at or before ``sent``.
            inputs: (u_psi, u_chi, u_v) at begin, begin + step, ..., shape (n, 3), held in between.
            step: Length of a segment in [s].
        """
        while self._plans and self._plans[-1][0] > sent:
            self._plans.pop()  # never flown: a clock that stood ahead has gone back
        self._plans.append((sent, begin, inputs.tolist(), step))
        while len(self._plans) > 1 and self._plans[1][0] <= sent - self.memory:
            self._plans.popleft()

    def demanded(self, time: float, axis: int) -> float:
        """Input demanded at a time by what has been sent so far.

        The last segment of a plan is held; before the first command nothing is demanded.

        Args:
            time: Past or future, in [s].
            axis: 0 for u_psi, 1 for u_chi, 2 for u_v.

        Returns:
            In [rad/s] or [m/s^2].
        """
        for sent, begin, inputs, step in reversed(self._plans):
            if sent <= time:
                return inputs[min(int((time - begin) / step), len(inputs) - 1)][axis]
        return 0.0
