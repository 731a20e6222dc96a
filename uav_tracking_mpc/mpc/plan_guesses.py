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

"""Plans from which a solver may begin: the last one moved on, or cold ones."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.mpc.problem import OptimalControlProblem
from uav_tracking_mpc.mpc.solution import Solution
from uav_tracking_mpc.mpc.solver import Guess, shift


class PlanGuess(NamedTuple):
    """Where a solver begins; states need not obey the dynamics.

    Attributes:
        states: x_0..x_N, shape (N + 1, nx).
        inputs: u_0..u_{N-1}, shape (N, nu).
        decision: a, shape (na,).
    """

    states: NDArray[np.float64]
    inputs: NDArray[np.float64]
    decision: NDArray[np.float64]


def plan_guesses(
    problem: OptimalControlProblem,
    initial_state: NDArray[np.float64],
    last: Solution | None,
    elapsed: float | None,
    make: Callable[[], Guess | None] | None,
    rollout: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]],
) -> list[PlanGuess]:
    """Plans to start from: the last one moved on, or that of the caller, or two cold ones.

    Args:
        problem: What is solved.
        initial_state: x_0, shape (nx,).
        last: The last plan that was one; None for a cold start.
        elapsed: Time in [s] since then; None for a cold start.
        make: Plan of the caller for a cold start.
        rollout: States x_0..x_N, shape (N + 1, nx), under inputs, shape (N, nu), and a decision,
            shape (na,).
    """
    if elapsed is not None and last is not None:
        stages = max(0.0, elapsed) / problem.step
        states = shift(last.states, stages)
        states[0] = initial_state
        return [PlanGuess(states, shift(last.inputs, stages), last.decision)]
    inputs = np.tile(problem.input_rest, (problem.horizon, 1))
    guess = make() if make is not None else None
    if guess is not None:
        inputs[: len(guess.inputs)] = guess.inputs
        decision = np.asarray(guess.decision)
        return [PlanGuess(rollout(inputs, decision), inputs, decision)]
    goal = np.zeros(problem.nx) if problem.state_goal is None else problem.state_goal
    later = (problem.horizon, 1)
    return [
        PlanGuess(np.vstack([initial_state, np.tile(rest, later)]), inputs, problem.decision_guess)
        for rest in (goal, initial_state)
    ]
