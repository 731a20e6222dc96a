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

"""The part of an autopilot that flies plans: the newest one, segment by segment, to its end."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike, NDArray

LEAD_LIMIT = 1.0  # s, by which a plan may begin in the future


class PlanFollower:
    """Keeps the newest plan and says which inputs it asks for.

    Args:
        delay: By which plans arrive and begin later than they say, in [s].

    Attributes:
        delay: As above; plans under way keep theirs.
        holding: Whether no plan was left when inputs were last asked for.
        failsafes: How often a plan came to its end with no other there.
    """

    def __init__(self, delay: float = 0.0) -> None:
        self.delay = delay
        self._under_way: deque[tuple[float, NDArray[np.float64], NDArray[np.float64]]] = deque()
        self.holding = True
        self.failsafes = 0
        self._inputs: NDArray[np.float64] | None = None
        self._starts = np.zeros(0)
        self._end = self._newest = -math.inf  # s, of the plan that is flown; the newest one's start

    @property
    def commanded(self) -> bool:
        """Whether a plan has ever arrived."""
        return self._inputs is not None

    def accept(self, inputs: ArrayLike, starts: ArrayLike, now: float) -> None:
        """Take over a plan.

        Args:
            inputs: (u_psi, u_chi, u_v) of each segment, shape (n, 3).
            starts: When each segment begins in [s], shape (n,), increasing; the last segment is
                as long as the one before it, a single one lasts 1 s.
            now: Present time in [s].

        Raises:
            ValueError: Empty, not finite, not in order, older than one that has come, or from the
                future; the present plan stays.
        """
        plan, starts = np.asarray(inputs, dtype=float), np.asarray(starts, dtype=float)
        if plan.ndim != 2 or plan.shape[1] != 3 or len(plan) == 0 or starts.shape != (len(plan),):
            raise ValueError(f"plan has shape {plan.shape}, must be (n, 3) with a start for each")
        if not (np.isfinite(plan).all() and np.isfinite(starts).all()):
            raise ValueError("plan holds values that are not finite")
        if (starts[1:] <= starts[:-1]).any():
            raise ValueError("plan's segments are not in order of time")
        self._forget_ahead(now)
        if starts[0] > now + LEAD_LIMIT:
            raise ValueError(
                f"plan begins {starts[0] - now:.3f} s from now, may by {LEAD_LIMIT:g} s"
            )
        if starts[0] < self._newest:
            raise ValueError("plan is older than one that has come before")
        self._newest = float(starts[0])
        if self.delay or self._under_way:
            self._under_way.append((now + self.delay, plan.copy(), starts + self.delay))
        else:
            self._fly(plan.copy(), starts)

    def _forget_ahead(self, now: float) -> None:
        """Where time has gone back, plans of a time that is no more are none."""
        if self._newest > now + LEAD_LIMIT:
            self._under_way.clear()
            self._starts, self._end = np.zeros(0), -math.inf
            self._newest = -math.inf

    def _fly(self, plan: NDArray[np.float64], starts: NDArray[np.float64]) -> None:
        self._inputs, self._starts = plan, starts
        self._end = starts[-1] + (starts[-1] - starts[-2] if len(starts) > 1 else 1.0)

    def inputs(self, now: float) -> NDArray[np.float64] | None:
        """(u_psi, u_chi, u_v) that the plan asks for, shape (3,); None where no plan is left.

        Args:
            now: Present time in [s].
        """
        self._forget_ahead(now)
        while self._under_way and self._under_way[0][0] <= now + 1e-9:
            _, plan, starts = self._under_way.popleft()
            self._fly(plan, starts)
        if self._inputs is not None and now < self._end:
            self.holding = False
            segment = int(np.searchsorted(self._starts, now + 1e-9, side="right")) - 1
            return self._inputs[max(segment, 0)]
        if not self.holding:
            self.holding = True
            self.failsafes += 1
        return None
