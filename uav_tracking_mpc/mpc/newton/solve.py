"""The entry: refuse bad data, start, minimise, keep the better plan."""

import math

from .clock import now as clock
from .compilation import compiled, entry
from .guesses import COLD_GUESSES, cold_guess, warm_guess
from .minimise import CONVERGED, TIME_LIMIT, better, copy_multipliers, copy_plan, minimise
from .stage import N, NP, NX
from .workspace import CHOSEN, KEPT, WORKING

REFUSED, NO_START = 5, 6


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
    iterations = 0
    status = NO_START
    w.outcome[1] = math.nan
    if elapsed_stages >= 0.0 and warm_guess(w, elapsed_stages):
        status, plan, count, gradient = minimise(w, tolerance, iteration_limit, deadline)
        iterations += count
        choose(w, plan, gradient)
    if status != CONVERGED and status != TIME_LIMIT:
        for guess in range(COLD_GUESSES):
            if not cold_guess(w, guess):
                continue
            ended, plan, count, gradient = minimise(w, tolerance, iteration_limit, deadline)
            iterations += count
            first = status == NO_START
            gains = (ended == CONVERGED) > (status == CONVERGED)
            loses = (ended == CONVERGED) < (status == CONVERGED)
            if first or gains or (not loses and better(w, plan, CHOSEN, tolerance)):
                choose(w, plan, gradient)
                status = ended
            if ended == TIME_LIMIT:
                break
    if status != NO_START:
        copy_plan(w, CHOSEN, KEPT)
        copy_multipliers(w, CHOSEN, KEPT)
        w.outcome[2] = w.value[CHOSEN, 1]
        w.outcome[3] = w.value[CHOSEN, 2]
    w.outcome[0] = iterations
    return status


@compiled
def choose(w, plan, gradient):
    """Remember a plan, its multipliers and its relative gradient."""
    copy_plan(w, plan, CHOSEN)
    copy_multipliers(w, WORKING, CHOSEN)
    w.outcome[1] = gradient


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
