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

"""One attempt: a guess, then sweep, line search on the rollout, multiplier update, until it stops.

Inside is Newton's method on the augmented Lagrangian. The multipliers are updated when its gradient
is small against the constraint residual, and also right after a full step that changed the merit
as its quadratic model predicted, since such a step ends at the minimum. So near a solution every
iteration updates both the plan and the multipliers.
"""

import math

from .backward_sweep import backward_sweep
from .clock import now as clock
from .multipliers import constraint_residual, exact_cost, merit, update_multipliers
from .numba_options import compiled, placed
from .rollout import rollout
from .stage import NA, NU, NX
from .workspace import BEST, FIRST, KEPT, NC, ROWS, SECOND, WORKING

# How it ends.
CONVERGED, ITERATION_LIMIT, TIME_LIMIT, INFEASIBLE, STALLED, REFUSED, NO_START, HOPELESS = range(8)

SUFFICIENT = 1e-4  # Armijo: share of the predicted change that a step must bring
SHORTEST = 1e-4  # of the step lengths tried
ROUNDING = 1e-13  # error of the merit, relative to 1 + its size
INNER = 0.1  # gradient, against the constraint residual, at which multipliers move
SHORT = 0.3
AS_PREDICTED = 0.1  # relative error of the change up to which a full step ends at a minimum
FORESEEN = 3.0  # changes like the one that a convex model predicts are at most still to come
DAMPING_START, DAMPING_LIMIT, DAMPING_GROWTH = 0.1, 1e8, 10.0


@placed
def attempt(w, tolerance, iteration_limit, deadline, bound):
    """Minimise from what stands in row SECOND and the gains; the plan is left in row KEPT.

    Args:
        w: Workspace.
        tolerance: Of the relative KKT residual.
        iteration_limit: Newton iterations.
        deadline: On the monotonic clock, in [s].
        bound: Cost that the plan must be likely to end below, else the attempt is given up.

    Returns:
        One of the codes above; ``outcome`` holds Newton iterations and the relative gradient, the
        plan's value its cost and violation.
    """
    w.outcome[0] = 0.0
    w.outcome[1] = math.nan
    rollout(w, SECOND, FIRST, 0.0)
    if not math.isfinite(w.value[FIRST, 0]):
        return NO_START

    now, trial = FIRST, SECOND
    exact_cost(w, now)
    copy_plan(w, now, BEST)
    value = merit(w, now)
    damping, curvature = 0.0, 1.0
    relative = 1.0
    status = ITERATION_LIMIT
    iteration = 0
    while iteration < iteration_limit:
        stationarity, scale, residual, predicted = backward_sweep(w, now, curvature, damping)
        relative = stationarity / scale
        if relative <= tolerance and residual <= tolerance:
            status = CONVERGED
            break
        convex = w.shifts[0] == 0.0
        if convex and value + FORESEEN * predicted > bound:
            w.outcome[0] = iteration
            return HOPELESS
        if clock(w.instant) > deadline:
            status = TIME_LIMIT
            break
        iteration += 1
        if residual > tolerance and relative <= max(tolerance, INNER * min(1.0, residual)):
            if not update_multipliers(w, now):
                status = INFEASIBLE
                break
            value = merit(w, now)
            continue
        length = 1.0
        accepted = False
        while length >= SHORTEST:
            rollout(w, now, trial, length)
            new = merit(w, trial)
            if new <= value + SUFFICIENT * length * predicted + ROUNDING * (1.0 + abs(value)):
                accepted = True
                break
            length *= 0.5
        if accepted:
            now, trial = trial, now
            error = abs(new - value - predicted)
            as_predicted = (
                length == 1.0
                and damping == 0.0
                and w.shifts[0] == 0.0
                and error <= AS_PREDICTED * abs(predicted) + ROUNDING * (1.0 + abs(value))
            )
            value = new
            exact_cost(w, now)
            if better(w, now, BEST, tolerance):
                copy_plan(w, now, BEST)
            curvature = 1.0
            if length < SHORT:
                damping = max(DAMPING_GROWTH * damping, DAMPING_START)
            elif length == 1.0:
                damping = damping / DAMPING_GROWTH if damping > DAMPING_START else 0.0
            if as_predicted and constraint_residual(w, now) > tolerance:
                if not update_multipliers(w, now):
                    status = INFEASIBLE
                    break
                value = merit(w, now)
        elif curvature > 0.0:
            curvature = 0.0
        else:
            damping = max(DAMPING_GROWTH * damping, DAMPING_START)
            if damping > DAMPING_LIMIT:
                status = STALLED
                break
    copy_plan(w, now if status == CONVERGED else BEST, KEPT)
    copy_multipliers(w, WORKING, KEPT)
    w.outcome[0] = iteration
    w.outcome[1] = relative
    return status


@compiled
def better(w, new, old, tolerance):
    """Whether a plan is feasible and cheaper than another, or less infeasible.

    Args:
        w: Workspace.
        new: Row of the one plan.
        old: Row of the other.
        tolerance: Largest violation of a plan that counts as feasible.
    """
    if w.value[new, 2] <= tolerance:
        return not w.value[old, 2] <= tolerance or w.value[new, 1] < w.value[old, 1]
    return w.value[new, 2] < w.value[old, 2]


@compiled
def copy_plan(w, source, target):
    """Copy a plan within the workspace ``w``, from row ``source`` to row ``target``."""
    for i in range(w.horizon[0] + 1):
        for r in range(NX):
            w.x[target, i, r] = w.x[source, i, r]
        for j in range(NC):
            w.c[target, i, j] = w.c[source, i, j]
    for i in range(w.horizon[0]):
        for j in range(NU):
            w.u[target, i, j] = w.u[source, i, j]
    for j in range(NA):
        w.a[target, j] = w.a[source, j]
    for j in range(3):
        w.value[target, j] = w.value[source, j]


@compiled
def copy_multipliers(w, source, target):
    """Copy multipliers and weights within ``w``, from row ``source`` to row ``target``."""
    for j in range(NC):
        for i in range(w.horizon[0] + 1):
            w.mu[target, i, j] = w.mu[source, i, j]
        for row in range(ROWS):
            w.rho[target, row, j] = w.rho[source, row, j]
