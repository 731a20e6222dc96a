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

"""The interface that every solver shares."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution


class Guess(NamedTuple):
    """A plan that the caller knows.

    Attributes:
        inputs: u_0..u_{N-1}, shape (N, nu).
        decision: a, shape (na,).
    """

    inputs: NDArray[np.float64]
    decision: NDArray[np.float64]


class Solver(Protocol):
    """Solves one problem again and again, from one state after the other.

    A solver keeps its last converged plan and starts from it, moved on by the time that has passed.
    It never raises on data and never returns an input that is not finite or outside the box: bad
    data gives :attr:`Status.REFUSED` and leaves everything that the solver holds as it was.

    Attributes:
        problem: What it solves.
        time_limit: Time budget of one solve in [s], may be set between solves; inf for none.
    """

    problem: OptimalControlProblem
    time_limit: float

    @property
    def name(self) -> str:
        """By which it is chosen."""
        ...

    def solve(
        self,
        initial_state: ArrayLike,
        parameters: ArrayLike | None = None,
        elapsed: float | None = None,
        guess: Callable[[], Guess | None] | None = None,
    ) -> Solution:
        """Solve P_N(x_0), (16).

        Args:
            initial_state: x_0, shape (nx,).
            parameters: p_0..p_N, shape (N + 1, np), or (np,) where they do not change; None for
                those of the problem.
            elapsed: Time in [s] since the state of the last solve, for the warm start; None for a
                cold start.
            guess: Called where a cold start is needed, also after a warm one has failed. The cold
                start tries the plan that it returns first, and others only if that fails.
        """
        ...

    def change(self, problem: OptimalControlProblem) -> None:
        """Solve the problem with other numbers from now on, starting cold.

        Args:
            problem: Of the same expressions; bounds, goal and ``parameter_values`` may differ.
        """
        ...

    def reset(self) -> None:
        """Forget the last plan: the next solve starts cold."""
        ...


def shift(samples: NDArray[np.float64], stages: float) -> NDArray[np.float64]:
    """Move a sequence forward in time by linear interpolation; the last sample is held.

    Args:
        samples: Values at stages 0..n-1, shape (n, m).
        stages: Elapsed time over T_s, any number >= 0 [-].

    Returns:
        Values at stages 0..n-1 from then on, shape (n, m).
    """
    count = len(samples)
    where = np.minimum(np.arange(count) + stages, count - 1.0)
    below = where.astype(int)
    above = np.minimum(below + 1, count - 1)
    weight = (where - below)[:, np.newaxis]
    return (1.0 - weight) * samples[below] + weight * samples[above]
