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

"""Fallback modes: from the optimal plan down to silence, one for everything that can fail.

A pure state machine: from what is available it chooses what to fly, and says why.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.mpc.solver import FEASIBLE_VIOLATION, Solution, Status

if TYPE_CHECKING:
    from uav_tracking_mpc.formulation.formulation import Plan

OWN_SOLVE = "the own solve is late"  # why nothing is sent, though states come
UNFINISHED = (Status.TIME_LIMIT, Status.ITERATION_LIMIT)


class FallbackMode(Enum):
    """What is flown, best first; the value is what people read."""

    OPTIMAL = "optimal plan"
    GUIDANCE_LAW = "guidance law"  # the one that was asked for in place of the predictive control
    FEASIBLE = "feasible plan, not optimal"
    EARLIER_PLAN = "earlier plan"
    LOITER = "loiter law"
    HOLD = "wings level"
    SILENCE = "silence"

    @property
    def nominal(self) -> bool:
        """Whether it is what was asked for."""
        return self in (FallbackMode.OPTIMAL, FallbackMode.GUIDANCE_LAW)

    @property
    def planned(self) -> bool:
        """Whether it is a plan of the predictive controller."""
        return self in (FallbackMode.OPTIMAL, FallbackMode.FEASIBLE, FallbackMode.EARLIER_PLAN)


@dataclass(frozen=True)
class Available:
    """What there is to fly by.

    Attributes:
        state: Whether a fresh and usable vehicle state is known.
        target: Whether a target position has ever been known.
        target_fresh: Whether the last one is young enough to plan with.
        solution: What the solver answered; None if it was not asked or failed.
        plan_left: Whether an earlier plan, young enough, has something left.
        law: Whether the guidance law that was asked for has answered.
        trouble: What is wrong with the inputs, in words; empty if nothing is.
    """

    state: bool = True
    target: bool = True
    target_fresh: bool = True
    solution: Solution | None = None
    plan_left: bool = False
    law: bool = False
    trouble: str = ""


def choose(available: Available) -> tuple[FallbackMode, str]:
    """Best mode that can be flown, and why it is none better (empty if it is nominal).

    Args:
        available: What there is to fly by.
    """
    solution, trouble = available.solution, available.trouble
    if not available.state:
        return FallbackMode.SILENCE, trouble or "vehicle state is lost"
    if not available.target:
        return FallbackMode.HOLD, trouble or "no target position"
    if not available.target_fresh:
        return FallbackMode.LOITER, trouble or "target position is lost"
    if solution is not None and solution.converged:
        return FallbackMode.OPTIMAL, ""
    if available.law:
        return FallbackMode.GUIDANCE_LAW, ""
    reason = trouble or "no solution"
    if not trouble and solution is not None:
        reason = solution.message or solution.status.value
    if (
        solution is not None
        and solution.status in UNFINISHED
        and solution.violation <= FEASIBLE_VIOLATION
    ):
        return FallbackMode.FEASIBLE, reason
    if available.plan_left:
        return FallbackMode.EARLIER_PLAN, reason
    return FallbackMode.LOITER, reason


class ModeSelector:
    """The mode that is flown, and how often each one has been.

    Attributes:
        mode: Present mode; SILENCE before the first selection.
        reason: Why it is none better; empty if it is nominal.
        counts: Commands in each mode.
        changes: How often the mode changed.
    """

    def __init__(self) -> None:
        self.mode = FallbackMode.SILENCE
        self.reason = "nothing has been received yet"
        self.counts = dict.fromkeys(FallbackMode, 0)
        self.changes = 0

    def select(self, available: Available) -> str:
        """Go to the best mode that can be flown.

        Args:
            available: What there is to fly by.

        Returns:
            The change in a sentence; empty if there is none.
        """
        mode, self.reason = choose(available)
        self.counts[mode] += 1
        before, self.mode = self.mode, mode
        if mode is before:
            return ""
        self.changes += 1
        silent, why = mode is FallbackMode.SILENCE, f": {self.reason}" if self.reason else ""
        now = "no command is sent" if silent else f"now flying {mode.value}"
        return f"{now}, before {before.value}{why}"


class PlanMemory:
    """Keeps one plan and what is left of it."""

    def __init__(self) -> None:
        self._plan: Plan | None = None
        self._begin = 0.0

    def reset(self) -> None:
        """Forget the plan."""
        self._plan = None

    def keep(self, plan: Plan, begin: float) -> None:
        """Remember a plan in the place of the one before.

        Args:
            plan: That is flown.
            begin: When its first segment begins in [s].
        """
        self._plan, self._begin = plan, begin

    @property
    def orbit(self) -> NDArray[np.float64] | None:
        """Range, altitude and airspeed of the orbit that the plan ends on, shape (3,), or None."""
        return None if self._plan is None else self._plan.orbit

    def remaining(self, time: float, age_max: float) -> tuple[NDArray[np.float64], float] | None:
        """What is left of the plan.

        Args:
            time: From which on in [s].
            age_max: Age at which a plan counts no more in [s].

        Returns:
            Inputs, shape (n, 3), n >= 1, and the length of a segment in [s]; None if there is
            no plan, or nothing left of it.
        """
        age = time - self._begin
        if self._plan is None or not 0.0 <= age <= age_max:
            return None
        inputs = self._plan.inputs[int(age / self._plan.step) :]
        return (inputs, self._plan.step) if len(inputs) else None
