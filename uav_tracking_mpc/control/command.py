"""What the controller answers: the inputs now, the plan after them, and where they come from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.mpc.solution import Solution, Status


@dataclass(frozen=True)
class Command:
    """What to fly now and, should nothing follow, after that.

    Attributes:
        stamp: Of the measurement that it answers, from which on it counts, in [s].
        inputs: (u_psi, u_chi, u_v) at stamp, stamp + step, ..., shape (n, 3), in [rad/s, rad/s,
            m/s^2]; inside the limits and held in between.
        step: In [s].
        mode: Where it comes from.
        reason: Why it is not optimal; empty if it is.
        orbit: What is flown.
        plan: What the predictive controller answered; None if it was not asked.
        present: Situation at the stamp; None where it is not known.
    """

    stamp: float
    inputs: NDArray[np.float64]
    step: float
    mode: FallbackMode
    reason: str
    orbit: Orbit
    plan: Plan | None
    present: Situation | None

    @property
    def solution(self) -> Solution | None:
        """What the solver answered."""
        return None if self.plan is None else self.plan.solution

    @property
    def out_of_time(self) -> bool:
        """Whether the solver met its time budget, so that the clock had a say in the plan."""
        return self.solution is not None and self.solution.status is Status.TIME_LIMIT
