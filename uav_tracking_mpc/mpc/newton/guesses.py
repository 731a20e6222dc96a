"""Where a solve begins: plans from which rollouts start."""

import math

from .backward_sweep import backward_sweep
from .compilation import compiled
from .multipliers import start_multipliers
from .rollout import rollout
from .stage import N, NA, NE, NH, NS, NU, NX
from .workspace import FIRST, KEPT, SECOND, WORKING

COLD_GUESSES = 2


@compiled
def cold_guess(w, guess):
    """Fill FIRST by a rollout of guess number 0..COLD_GUESSES - 1; False if it is not finite.

    0: feedback to the goal, the gains of the Riccati recursion about a plan that rests there.
    1: inputs at rest.
    """
    start_multipliers(w)
    rest(w, SECOND)
    if guess == 0:
        stage_constraints_at_rest(w)
        backward_sweep(w, SECOND, 0.0, 0.0)
        for i in range(N):
            for j in range(NU):
                w.k[i, j] = 0.0
        for j in range(NA):
            w.k_a[j] = 0.0
    else:
        no_step(w)
    rollout(w, SECOND, FIRST, 0.0)
    return math.isfinite(w.value[FIRST, 0])


@compiled
def warm_guess(w, stages):
    """Fill FIRST by a rollout of the kept plan moved on by ``stages``; False if it is not finite.

    Args:
        w: Workspace.
        stages: Elapsed time over T_s, any number >= 0.
    """
    for i in range(N):
        where = min(i + stages, N - 1.0)
        below = int(where)
        above = min(below + 1, N - 1)
        share = where - below
        for j in range(NU):
            w.u[SECOND, i, j] = (1.0 - share) * w.u[KEPT, below, j] + share * w.u[KEPT, above, j]
        for j in range(NH):
            w.mu_h[WORKING, i, j] = (1.0 - share) * w.mu_h[KEPT, below, j] + share * w.mu_h[
                KEPT, above, j
            ]
    for j in range(NA):
        w.a[SECOND, j] = w.a[KEPT, j]
    for j in range(NH):
        w.rho_h[WORKING, j] = w.rho_h[KEPT, j]
        w.residual_h[j] = math.inf
    for j in range(NE):
        w.mu_e[WORKING, j] = w.mu_e[KEPT, j]
        w.rho_e[WORKING, j] = w.rho_e[KEPT, j]
        w.residual_e[j] = math.inf
    no_step(w)
    rollout(w, SECOND, FIRST, 0.0)
    return math.isfinite(w.value[FIRST, 0])


@compiled
def rest(w, plan):
    """A plan that rests at the goal: inputs as near to 0 as the box allows."""
    for i in range(N + 1):
        for r in range(NX):
            w.x[plan, i, r] = w.goal[r]
    for i in range(N):
        for j in range(NU):
            w.u[plan, i, j] = min(max(0.0, w.u_lower[j]), w.u_upper[j])
    for j in range(NA):
        w.a[plan, j] = w.a_guess[j]


@compiled
def stage_constraints_at_rest(w):
    """Constraint values far inside, so that the sweep at rest sees none."""
    for i in range(N):
        for j in range(NH):
            w.h[SECOND, i, j] = -1e6
    for j in range(NE):
        w.e[SECOND, j] = 0.0


@compiled
def no_step(w):
    """k = 0, K = 0: a rollout repeats the inputs of its plan."""
    for i in range(N):
        for j in range(NU):
            w.k[i, j] = 0.0
            for r in range(NS):
                w.K[i, j, r] = 0.0
    for j in range(NA):
        w.k_a[j] = 0.0
