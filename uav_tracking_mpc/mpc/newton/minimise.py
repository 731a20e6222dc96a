"""The iteration: sweep, line search on the rollout, multiplier update, stopping.

Inside, Newton's method on the augmented Lagrangian; once its gradient is small against the
constraint residual, the multipliers move and the next Newton step sees the new merit. Near a
solution both happen in every iteration.
"""

from .backward_sweep import backward_sweep
from .clock import now as clock
from .compilation import compiled
from .multipliers import exact_cost, merit, update_multipliers
from .rollout import rollout
from .stage import NA, NE, NH, NU, NX
from .workspace import BEST, FIRST, SECOND

CONVERGED, ITERATION_LIMIT, TIME_LIMIT, INFEASIBLE, STALLED = range(5)

SUFFICIENT = 1e-4  # Armijo: share of the predicted change that a step must bring
SHORTEST = 1e-4  # of the step lengths tried
ROUNDING = 1e-13  # relative rounding error of the merit
INNER = 0.1  # gradient, against the constraint residual, at which multipliers move
SHORT = 0.3
DAMPING_START, DAMPING_LIMIT, DAMPING_GROWTH = 1e-2, 1e8, 10.0


@compiled
def minimise(w, tolerance, iteration_limit, deadline):
    """Minimise from the plan in FIRST, which a rollout has filled.

    Args:
        w: Workspace.
        tolerance: Of the KKT residual, relative.
        iteration_limit: Newton iterations.
        deadline: On the monotonic clock, in [s].

    Returns:
        status: One of the codes above.
        plan: Where the final plan lies.
        iterations: Newton iterations.
        stationarity: Relative gradient of the Lagrangian, projected on the box.
    """
    now, trial = FIRST, SECOND
    w.trace[:]=0.0
    exact_cost(w, now)
    copy_plan(w, now, BEST)
    value = merit(w, now)
    w.outcome[4]=value
    damping, curvature = 0.0, 1.0
    relative = 1.0
    status = ITERATION_LIMIT
    iteration = 0
    while iteration < iteration_limit:
        stationarity, scale, residual, predicted = backward_sweep(w, now, curvature, damping)
        relative = stationarity / scale
        if iteration < 300:
            w.trace[iteration, 0] = value; w.trace[iteration, 1] = stationarity; w.trace[iteration, 2] = scale; w.trace[iteration, 3] = residual; w.trace[iteration, 4] = predicted; w.trace[iteration, 5] = damping; w.trace[iteration, 6] = w.shifts[0]; w.trace[iteration, 7] = w.rho_e[0,0]; w.trace[iteration,8]=w.mu_e[0,0]; w.trace[iteration,9]=0
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
            if new <= value + SUFFICIENT * length * predicted + ROUNDING * abs(value):
                accepted = True
                break
            length *= 0.5
            w.trace[iteration-1,9] += 1
        if accepted:
            now, trial = trial, now
            value = new
            exact_cost(w, now)
            if better(w, now, BEST, tolerance):
                copy_plan(w, now, BEST)
            curvature = 1.0
            if length < SHORT:
                damping = max(DAMPING_GROWTH * damping, DAMPING_START)
            elif length == 1.0:
                damping = damping / DAMPING_GROWTH if damping > DAMPING_START else 0.0
        elif curvature > 0.0:
            curvature = 0.0
        else:
            damping = max(DAMPING_GROWTH * damping, DAMPING_START)
            if damping > DAMPING_LIMIT:
                status = STALLED
                break
    if status != CONVERGED:
        now = BEST
    return status, now, iteration, relative


@compiled
def better(w, new, old, tolerance):
    """Whether a plan is feasible and cheaper than another, or less infeasible."""
    if w.value[new, 2] <= tolerance:
        return not w.value[old, 2] <= tolerance or w.value[new, 1] < w.value[old, 1]
    return w.value[new, 2] < w.value[old, 2]


@compiled
def copy_plan(w, source, target):
    """Plan ``target`` <- plan ``source``."""
    for i in range(w.horizon[0] + 1):
        for r in range(NX):
            w.x[target, i, r] = w.x[source, i, r]
    for i in range(w.horizon[0]):
        for j in range(NU):
            w.u[target, i, j] = w.u[source, i, j]
        for j in range(NH):
            w.h[target, i, j] = w.h[source, i, j]
    for j in range(NA):
        w.a[target, j] = w.a[source, j]
    for j in range(NE):
        w.e[target, j] = w.e[source, j]
    for j in range(3):
        w.value[target, j] = w.value[source, j]


@compiled
def copy_multipliers(w, source, target):
    """Multipliers and weights of row ``target`` <- those of row ``source``."""
    for j in range(NH):
        for i in range(w.horizon[0]):
            w.mu_h[target, i, j] = w.mu_h[source, i, j]
        w.rho_h[target, j] = w.rho_h[source, j]
    for j in range(NE):
        w.mu_e[target, j] = w.mu_e[source, j]
        w.rho_e[target, j] = w.rho_e[source, j]
