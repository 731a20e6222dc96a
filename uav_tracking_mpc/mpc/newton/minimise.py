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

"""The entry of compiled code: an attempt from a warm start, or from a plan of the caller.

A warm start begins at the better of two plans, by their merit: the last one shifted by the time
that has passed, and the last one as it stands, corrected for the new initial state by the gains of
its last sweep. The second is a Newton step of the problem from that state. It is nearly the optimum
where the plan moves along with the aircraft, as on the way to an orbit that it does not reach yet.

An attempt is Newton's method on the augmented Lagrangian. The multipliers are updated when its
gradient is small against the constraint residual, and also right after a full step that changed the
merit as its quadratic model predicted, since such a step ends at the minimum. So near a solution
every iteration updates both the plan and the multipliers.
"""

import math

from .backward_sweep import backward_sweep, decision_feedback
from .compiling import compiled, entry, placed
from .compiling import now as clock
from .lagrangian import merit, rollout, update_multipliers
from .stage import NA, NP, NS, NU, NX, N, continuation
from .workspace import BEST, FIRST, KEPT, NC, ROWS, SECOND, WORKING, record_at

WEIGHT_KEPT = 1e3  # -, largest penalty weight to begin with


@compiled
def move_on(w, stages):
    """Inputs, decisions and multipliers of row KEPT, ``stages`` later, into row SECOND.

    Values between two stages are interpolated linearly; the input after the last stage is the
    problem's continuation. The gains are 0, so that a rollout repeats the inputs. Penalty weights
    above :data:`WEIGHT_KEPT` are reduced to it: larger ones would force the next plan to follow
    the curved surface on which the constraints hold, and allow only short steps along it.

    Args:
        w: Workspace.
        stages: Elapsed time over T_s, any number >= 0.
    """
    unshifted(w)
    continuation((w.x[KEPT, N], w.u[KEPT, N - 1], w.a[KEPT], w.p[N]), (w.u_end,))
    for i in range(N):
        where = min(i + stages, float(N))
        below = min(int(where), N - 1)
        above = min(below + 1, N - 1)
        share = where - below
        for j in range(NU):
            later = w.u[KEPT, above, j] if above > below else w.u_end[j]
            u = (1.0 - share) * w.u[KEPT, below, j] + share * later
            w.u[SECOND, i, j] = min(max(u, w.u_lower[j]), w.u_upper[j])
            w.k[i, j] = 0.0
            for r in range(NS):
                w.K[i, j, r] = 0.0
        for j in range(NC):
            low, high = w.mu[KEPT, below, j], w.mu[KEPT, above, j]
            w.mu[WORKING, i, j] = (1.0 - share) * low + share * high
    for j in range(NA):
        w.a[SECOND, j] = w.a[KEPT, j]
        w.k_a[j] = 0.0


@compiled
def warm_start(w, stages):
    """The better of the plans of a warm start into row FIRST, its multipliers into WORKING.

    The shifted plan is feasible where the last one was and the problem's continuation keeps it so:
    row BEST holds it, to be returned if time runs out before there is a better one.

    Args:
        w: Workspace, with the gains of the last sweep.
        stages: Elapsed time over T_s, any number >= 0.
    """
    unshifted(w)
    decision_feedback(w, KEPT)
    rollout(w, KEPT, FIRST, 1.0)
    followed = merit(w, FIRST)
    move_on(w, stages)
    rollout(w, SECOND, BEST, 0.0)
    shifted = merit(w, BEST)
    if math.isfinite(followed) and not shifted <= followed:
        unshifted(w)
    else:
        copy_plan(w, BEST, FIRST)


@compiled
def unshifted(w):
    """Multipliers of row KEPT into row WORKING of ``w``, with weights of at most WEIGHT_KEPT."""
    copy_multipliers(w, KEPT, WORKING)
    for j in range(NC):
        for row in range(ROWS):
            w.rho[WORKING, row, j] = min(w.rho[WORKING, row, j], WEIGHT_KEPT)
            w.residual[row, j] = math.inf


# How it ends.
CONVERGED, ITERATION_LIMIT, TIME_LIMIT, INFEASIBLE, STALLED, REFUSED, NO_START, HOPELESS = range(8)

SUFFICIENT = 1e-4  # -, Armijo's share of the predicted change that a step must bring
SHORTEST = 1e-4  # -, share of a full step: the shortest that is tried
ROUNDING = 1e-13  # -, rounding of the merit, relative to 1 + its size
INNER = 0.1  # -, ratio of gradient to constraint residual at which multipliers move
SHORT = 0.3  # -, share of a full step: after a shorter one the damping grows
AS_PREDICTED = 0.1  # -, relative error of the change up to which a full step ends at a minimum
FORESEEN = 3.0  # -, times the change that a convex model predicts is at most still to come
# -, times the identity that is added to the Hessian, and the factor of its growth
DAMPING_START, DAMPING_LIMIT, DAMPING_GROWTH = 0.1, 1e8, 10.0


@placed
def attempt(w, tolerance, iteration_limit, deadline, bound):
    """Minimise from the plan in row FIRST; row KEPT gets the plan found, or that in BEST if better.

    Args:
        w: Workspace.
        tolerance: Of the relative KKT residual.
        iteration_limit: Newton iterations.
        deadline: On the monotonic clock, in [s].
        bound: Cost that the plan must be likely to end below, else the attempt is given up.

    Returns:
        One of the codes above.
    """
    w.outcome[0], w.outcome[1] = 0.0, math.nan
    if not math.isfinite(w.value[FIRST, 0]):
        return NO_START

    now, trial = FIRST, SECOND
    value = w.outcome[2] = merit(w, now)
    if better(w, now, BEST, tolerance):
        copy_plan(w, now, BEST)
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
            if better(w, now, BEST, tolerance):
                copy_plan(w, now, BEST)
            curvature = 1.0
            if length < SHORT:
                damping = max(DAMPING_GROWTH * damping, DAMPING_START)
            elif length == 1.0:
                damping = damping / DAMPING_GROWTH if damping > DAMPING_START else 0.0
            if as_predicted and w.value[now, 3] > tolerance:
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
    for j in range(4):
        w.value[target, j] = w.value[source, j]


@compiled
def copy_multipliers(w, source, target):
    """Copy multipliers and weights within ``w``, from row ``source`` to row ``target``."""
    for j in range(NC):
        for i in range(w.horizon[0] + 1):
            w.mu[target, i, j] = w.mu[source, i, j]
        for row in range(ROWS):
            w.rho[target, row, j] = w.rho[source, row, j]


# How it begins: from the kept plan; from what the caller has put into row SECOND and the gains. Or
# nothing but a sweep about row SECOND and its constraints c, for its gains.
WARM, PREPARED, SWEEP = range(3)


@entry
def minimise(address, start, stages, tolerance, iteration_limit, deadline, bound):
    """Minimise the problem of a workspace; the plan is left in row KEPT.

    Args:
        address: Of the workspace in memory; x_0, p, horizon and ends are set.
        start: One of the codes above.
        stages: WARM: elapsed time over T_s.
        tolerance: Of the relative KKT residual.
        iteration_limit: Newton iterations.
        deadline: On the monotonic clock, in [s].
        bound: Cost that the plan must be likely to end below, else the attempt is given up.

    Returns:
        How it ended; ``outcome`` holds Newton iterations, the relative gradient and the merit at
        the start, the plan's value its cost and violation.
    """
    w = record_at(address)
    if not data_finite(w):
        return REFUSED
    if start == SWEEP:
        backward_sweep(w, SECOND, 0.0, 0.0)
        return CONVERGED
    if start == WARM:
        warm_start(w, stages)
    else:
        rollout(w, SECOND, FIRST, 0.0)
        w.value[BEST, 2] = math.inf
    return attempt(w, tolerance, iteration_limit, deadline, bound)


@compiled
def data_finite(w):
    """Whether x_0 and p of the workspace ``w`` are finite."""
    for r in range(NX):
        if not math.isfinite(w.x_0[r]):
            return False
    for i in range(N + 1):
        for r in range(NP):
            if not math.isfinite(w.p[i, r]):
                return False
    return True
