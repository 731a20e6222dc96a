"""The ladder: from the optimal plan down to silence, one rung for everything that can fail.

A pure state machine: it is told what there is, and says what to fly and why.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from uav_tracking_mpc.mpc.solution import Solution, Status

FEASIBLE_VIOLATION = 1e-2  # of hard constraints, in their own scale, that a plan may be flown with
UNFINISHED = (Status.TIME_LIMIT, Status.ITERATION_LIMIT)


class Rung(Enum):
    """What is flown, best first; the value is what people read."""

    OPTIMAL = "optimal plan"
    FEASIBLE = "feasible plan, not optimal"
    EARLIER_PLAN = "earlier plan"
    LOITER = "loiter law"
    HOLD = "wings level"
    SILENCE = "silence"

    @property
    def planned(self) -> bool:
        """Whether it is a plan of the predictive controller."""
        return self in (Rung.OPTIMAL, Rung.FEASIBLE, Rung.EARLIER_PLAN)


RUNGS = tuple(Rung)


@dataclass(frozen=True)
class Footing:
    """What there is to stand on.

    Attributes:
        state: Whether a fresh and usable vehicle state is known.
        target: Whether a target position has ever been known.
        target_fresh: Whether the last one is young enough to plan with.
        solution: What the solver said; None if it was not asked or broke.
        plan_left: Whether an earlier plan, young enough, has something left.
        trouble: What is wrong with the inputs, in words; empty if nothing is.
    """

    state: bool
    target: bool
    target_fresh: bool
    solution: Solution | None
    plan_left: bool
    trouble: str = ""


@dataclass(frozen=True)
class Change:
    """A step on the ladder.

    Attributes:
        before: Rung left.
        after: Rung reached.
        reason: Why; empty on the top rung.
    """

    before: Rung
    after: Rung
    reason: str

    def __str__(self) -> str:
        """The change in a sentence."""
        if self.after is Rung.OPTIMAL:
            return f"now flying {self.after.value}s, before {self.before.value}"
        return f"now flying {self.after.value}, before {self.before.value}: {self.reason}"


def choose(footing: Footing) -> tuple[Rung, str]:
    """Highest rung that holds, and why it is none higher (empty on the top)."""
    solution = footing.solution
    if not footing.state:
        return Rung.SILENCE, footing.trouble or "vehicle state is lost"
    if not footing.target:
        return Rung.HOLD, footing.trouble or "no target position"
    if not footing.target_fresh:
        return Rung.LOITER, footing.trouble or "target position is lost"
    if solution is not None and solution.converged:
        return Rung.OPTIMAL, ""
    reason = footing.trouble or "no solution"
    if not footing.trouble and solution is not None:
        reason = solution.message or solution.status.value
    if (
        solution is not None
        and solution.status in UNFINISHED
        and solution.violation <= FEASIBLE_VIOLATION
    ):
        return Rung.FEASIBLE, reason
    if footing.plan_left:
        return Rung.EARLIER_PLAN, reason
    return Rung.LOITER, reason


class Ladder:
    """Where one stands, and how often one has stood where.

    Attributes:
        rung: Present rung; SILENCE before the first step.
        reason: Why it is none higher; empty on the top.
        counts: Steps spent on each rung.
        changes: How often the rung changed.
    """

    def __init__(self) -> None:
        self.rung = Rung.SILENCE
        self.reason = "nothing has been received yet"
        self.counts = dict.fromkeys(RUNGS, 0)
        self.changes = 0

    def step(self, footing: Footing) -> Change | None:
        """Step to the highest rung that holds; the change, if there is one."""
        rung, self.reason = choose(footing)
        self.counts[rung] += 1
        before, self.rung = self.rung, rung
        if rung is before:
            return None
        self.changes += 1
        return Change(before, rung, self.reason)
