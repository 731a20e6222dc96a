"""Commands that were sent, as the aircraft will still be flying them: dead time, then the plan."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray


class CommandHistory:
    """Plans by the time at which they were sent.

    Args:
        memory: For how long a plan matters after another has replaced it, in [s].
    """

    def __init__(self, memory: float) -> None:
        self._memory = memory
        self._plans: deque[tuple[float, NDArray[np.float64], float]] = deque()

    def reset(self) -> None:
        """Forget every command."""
        self._plans.clear()

    def add(self, time: float, plan: NDArray[np.float64], step: float) -> None:
        """A plan is sent.

        Args:
            time: When its first inputs are commanded in [s].
            plan: (u_psi, u_chi, u_v) at 0, step, 2 step, ..., shape (n, 3), held in between.
            step: In [s].
        """
        self._plans.append((time, plan, step))
        while len(self._plans) > 1 and self._plans[1][0] <= time - self._memory:
            self._plans.popleft()

    def demanded(self, time: float, axis: int) -> float:
        """Input that was or will be demanded at a time, by what has been sent so far.

        The last segment of a plan is held; before the first command nothing is demanded.
        """
        for start, plan, step in reversed(self._plans):
            if start <= time:
                return float(plan[min(int((time - start) / step), len(plan) - 1), axis])
        return 0.0
