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

"""What the controller answers: the inputs now, the plan after them, and where they come from."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics.orbit import FlownOrbit, Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.formulation import Plan
from uav_tracking_mpc.mpc.solver import Solution, Status


class Command(NamedTuple):
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
        flown_orbit: What the inputs lead to at the stamp, or go on around: what an autopilot that
            holds altitude and airspeed itself is told; None where no target is known.
    """

    stamp: float
    inputs: NDArray[np.float64]
    step: float
    mode: FallbackMode
    reason: str
    orbit: Orbit
    plan: Plan | None
    present: Situation | None
    flown_orbit: FlownOrbit | None

    @property
    def solution(self) -> Solution | None:
        """What the solver answered."""
        return None if self.plan is None else self.plan.solution

    @property
    def out_of_time(self) -> bool:
        """Whether the solver met its time budget, so that the clock had a say in the plan."""
        return self.solution is not None and self.solution.status is Status.TIME_LIMIT
