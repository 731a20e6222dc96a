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
from .numba_options import compiled, entry
from .rollout import rollout
from .stage import NA, NP, NU, NX, N
from .warm_start import move_on
from .workspace import BEST, FIRST, KEPT, NC, ROWS, SECOND, WORKING, record_at

# How an attempt begins: from the kept plan moved on, or from what the caller put into row SECOND
# and the gains; or only a sweep about that row, for its gains.
WARM, PREPARED, SWEEP = range(3)

# How it ends.
CONVERGED, ITERATION_LIMIT, TIME_LIMIT, INFEASIBLE, STALLED, REFUSED, NO_START = range(7)

SUFFICIENT = 1e-4  # Armijo: share of the predicted change that a step must bring
SHORTEST = 1e-4  # of the step lengths tried
ROUNDING = 1e-13  # error of the merit, relative to 1 + its size
INNER = 0.1  # gradient, against the constraint residual, at which multipliers move
SHORT = 0.3
AS_PREDICTED = 0.1  # relative error of the change up to which a full step ends at a minimum
DAMPING_START, DAMPING_LIMIT, DAMPING_GROWTH = 1e-2, 1e8, 10.0


@entry
def minimise(address, start, stages, tolerance, iteration_limit, deadline):
    """Minimise from a guess; the plan is left in row KEPT.

    Args:
        address: Of the workspace in memory; x_0, p, horizon and ends are set.
        start: One of the codes above.
        stages: WARM: elapsed time over T_s.
        tolerance: Of the relative KKT residual.
        iteration_limit: Newton iterations.
        deadline: On the monotonic clock, in [s].

    Returns:
        One of the codes above; ``outcome`` holds Newton iterations and the relative gradient, the
        plan's value its cost and violation.
    """
    w = record_at(address)
    if not data_finite(w):
        return REFUSED
    w.outcome[0] = 0.0
    w.outcome[1] = math.nan
    if start == SWEEP:
        backward_sweep(w, SECOND, 0.0, 0.0)
        return CONVERGED
    if start == WARM:
        move_on(w, stages)
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
