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

"""Openings: inputs held for a few stages, then feedback to the goal."""

import math

from .backward_sweep import backward_sweep
from .multipliers import merit
from .numba_options import compiled
from .rollout import rollout
from .stage import NA, NS, NU, NX
from .workspace import FIRST, NC, OPENINGS, ROWS, SECOND, WORKING

WEIGHT = 10.0  # rho to begin with
INSIDE = -1e6  # of a constraint: so far inside that a sweep does not see it


@compiled
def prepare(w, opening):
    """Reference of a rollout into row SECOND: an opening, then feedback to the goal.

    Args:
        w: Workspace.
        opening: Which.
    """
    end, held = w.horizon[0], int(w.held[opening])
    for i in range(end + 1):
        for r in range(NX):
            w.x[SECOND, i, r] = w.goal[r]
        for j in range(NC):
            w.mu[WORKING, i, j] = 0.0
    for i in range(end):
        for j in range(NU):
            w.u[SECOND, i, j] = w.opening[opening, j] if i < held else w.opening[0, j]
            w.k[i, j] = 0.0
            for r in range(NS):
                w.K[i, j, r] = 0.0 if i < held else w.policy[j, r]
    for j in range(NA):
        w.a[SECOND, j] = w.a_guess[j]
        w.k_a[j] = 0.0
    for j in range(NC):
        for row in range(ROWS):
            w.rho[WORKING, row, j] = WEIGHT
            w.residual[row, j] = math.inf


@compiled
def feedback_to_goal(w):
    """Gains at stage 0 of a Riccati recursion about rest at the goal, into the policy of ``w``."""
    prepare(w, 0)
    end = w.horizon[0]
    for i in range(end + 1):
        for j in range(NC):
            w.c[SECOND, i, j] = 0.0 if i == end else INSIDE
    backward_sweep(w, SECOND, 0.0, 0.0)
    finite = True
    for j in range(NU):
        for r in range(NS):
            finite = finite and math.isfinite(w.K[0, j, r])
    for j in range(NU):
        for r in range(NS):
            w.policy[j, r] = w.K[0, j, r] if finite else 0.0


@compiled
def open_all(w):
    """Roll out every opening of the workspace ``w``: its cost is the promise."""
    for opening in range(OPENINGS):
        prepare(w, opening)
        rollout(w, SECOND, FIRST, 0.0)
        w.promise[opening] = merit(w, FIRST)


@compiled
def prepare_cheapest(w):
    """Prepare the cheapest opening not tried yet; False if there is none.

    Args:
        w: Workspace, with the promises.
    """
    cheapest = -1
    for opening in range(OPENINGS):
        promise = w.promise[opening]
        if math.isfinite(promise) and (cheapest < 0 or promise < w.promise[cheapest]):
            cheapest = opening
    if cheapest < 0:
        return False
    w.promise[cheapest] = math.inf
    prepare(w, cheapest)
    return True
