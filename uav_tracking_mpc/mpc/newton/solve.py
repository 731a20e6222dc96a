"""The entry: refuse bad data, start, minimise, keep the best plan."""

import math

from .clock import now as clock
from .compilation import compiled, entry
from .guesses import OPENINGS, SHORT_HORIZON, extension, feedback_to_goal, opening, warm_guess
from .minimise import CONVERGED, TIME_LIMIT, better, copy_multipliers, copy_plan, minimise
from .multipliers import start_multipliers
from .stage import N, NE, NP, NX
from .workspace import CHOSEN, KEPT, RUNNER_UP, SHORT, WORKING

REFUSED, NO_START = 5, 6
COARSE_TOLERANCE, COARSE_ITERATIONS = 1e-3, 40  # on the shorter horizon
DISTINCT = 1e-3  # relative difference in cost of two local minima


@entry
def solve(workspace, elapsed_stages, tolerance, iteration_limit, time_limit):
    """Solve from x_0 and p in the workspace; the plan is left in row CHOSEN.

    Args:
        workspace: Array of one record, see ``workspace``.
        elapsed_stages: Time since the kept plan over T_s; negative for a cold start.
        tolerance: Of the relative KKT residual.
        iteration_limit: Newton iterations from each guess.
        time_limit: For the whole solve, in [s].

    Returns:
        Status, of those in ``minimise`` and above; the rest is in ``outcome``: iterations, relative
        gradient, cost, violation.
    """
    w = workspace[0]
    if not data_finite(w):
        return REFUSED
    deadline = clock(w.instant) + time_limit
    w.horizon[0], w.ends[0] = N, NE
    w.outcome[0] = 0.0
    w.outcome[1] = math.nan
    status = NO_START
    if elapsed_stages >= 0.0 and warm_guess(w, elapsed_stages):
        status = refine(w, status, tolerance, iteration_limit, deadline)
    if status != CONVERGED and status != TIME_LIMIT:
        status = cold_start(w, status, tolerance, iteration_limit, deadline)
    if status != NO_START:
        copy_plan(w, CHOSEN, KEPT)
        copy_multipliers(w, CHOSEN, KEPT)
        w.outcome[2] = w.value[CHOSEN, 1]
        w.outcome[3] = w.value[CHOSEN, 2]
    return status


@compiled
def cold_start(w, status, tolerance, iteration_limit, deadline):
    """Minimise from every cold guess; the best plan is left in CHOSEN."""
    feedback_to_goal(w)
    openings = OPENINGS
    if N > SHORT_HORIZON:
        found = shorter_horizon(w, deadline)
        w.horizon[0], w.ends[0] = N, NE
        if found > 0 and extension(w, SHORT, SHORT_HORIZON):
            status = refine_cold(w, status, tolerance, iteration_limit, deadline)
        if found > 1 and extension(w, RUNNER_UP, SHORT_HORIZON):
            status = refine_cold(w, status, tolerance, iteration_limit, deadline)
        openings = 2
    for number in range(openings):
        if status == TIME_LIMIT:
            break
        if opening(w, number):
            status = refine_cold(w, status, tolerance, iteration_limit, deadline)
    return status


@compiled
def shorter_horizon(w, deadline):
    """Two best distinct plans of a shorter horizon, in SHORT and RUNNER_UP; returns how many.

    Terminal constraints belong to the end of the whole horizon: there are none here.
    """
    w.horizon[0], w.ends[0] = SHORT_HORIZON, 0
    found = 0
    for number in range(OPENINGS):
        if not opening(w, number):
            continue
        start_multipliers(w)
        _, plan, count, _ = minimise(w, COARSE_TOLERANCE, COARSE_ITERATIONS, deadline)
        w.outcome[0] += count
        if found == 0 or better(w, plan, SHORT, COARSE_TOLERANCE):
            if found > 0 and distinct(w, plan, SHORT):
                copy_plan(w, SHORT, RUNNER_UP)
                found = 2
            copy_plan(w, plan, SHORT)
            found = max(found, 1)
        elif distinct(w, plan, SHORT) and (
            found == 1 or better(w, plan, RUNNER_UP, COARSE_TOLERANCE)
        ):
            copy_plan(w, plan, RUNNER_UP)
            found = 2
    return found


@compiled
def distinct(w, one, other):
    """Whether two plans differ in cost by more than two runs to the same minimum would."""
    return abs(w.value[one, 1] - w.value[other, 1]) > DISTINCT * abs(w.value[other, 1])


@compiled
def refine_cold(w, status, tolerance, iteration_limit, deadline):
    """:func:`refine` without multipliers from before."""
    start_multipliers(w)
    return refine(w, status, tolerance, iteration_limit, deadline)


@compiled
def refine(w, status, tolerance, iteration_limit, deadline):
    """Minimise from FIRST; the plan becomes CHOSEN if it is the better one.

    Returns:
        Status of the plan in CHOSEN, or TIME_LIMIT once time is up.
    """
    ended, plan, count, gradient = minimise(w, tolerance, iteration_limit, deadline)
    w.outcome[0] += count
    gains = (ended == CONVERGED) > (status == CONVERGED)
    loses = (ended == CONVERGED) < (status == CONVERGED)
    if status == NO_START or gains or (not loses and better(w, plan, CHOSEN, tolerance)):
        copy_plan(w, plan, CHOSEN)
        copy_multipliers(w, WORKING, CHOSEN)
        w.outcome[1] = gradient
        status = ended
    return TIME_LIMIT if ended == TIME_LIMIT and status != CONVERGED else status


@compiled
def data_finite(w):
    """Whether x_0 and p hold numbers only."""
    for r in range(NX):
        if not math.isfinite(w.x_0[r]):
            return False
    for i in range(N + 1):
        for r in range(NP):
            if not math.isfinite(w.p[i, r]):
                return False
    return True
