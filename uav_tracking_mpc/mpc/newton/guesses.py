"""Where a solve begins: plans from which rollouts start.

A cold start tries several, because the problem has local minima: inputs at rest, feedback to the
goal, and that feedback after a few stages with inputs held near a bound ("openings"). A long horizon
multiplies the local minima while a short one has few, so beyond ``SHORT_HORIZON`` the openings are
tried on a horizon of that length and the two best plans are extended by the feedback.
"""

import math

from .backward_sweep import backward_sweep
from .compilation import compiled
from .multipliers import start_multipliers
from .rollout import rollout
from .stage import N, NA, NE, NH, NS, NU, NX
from .workspace import FIRST, KEPT, SECOND, WORKING

SHORT_HORIZON = 20
OPENING_STAGES = 6
OPENING_SHARE = 0.9  # of the way from the middle of the box to its bound
OPENINGS = 2 + 2 * NU + 2 ** min(NU, 3)


@compiled
def feedback_to_goal(w):
    """Gains of the Riccati recursion about a plan that rests at the goal, into ``policy``."""
    start_multipliers(w)
    rest_at_goal(w)
    for i in range(w.horizon[0]):
        for j in range(NH):
            w.h[SECOND, i, j] = -1e6  # far inside: the sweep sees no inequality
    for j in range(NE):
        w.e[SECOND, j] = 0.0
    backward_sweep(w, SECOND, 0.0, 0.0)
    for j in range(NU):
        for r in range(NS):
            w.policy[j, r] = w.K[0, j, r] if math.isfinite(w.K[0, j, r]) else 0.0


@compiled
def opening(w, number):
    """Fill FIRST with opening 0..OPENINGS - 1; False if it is not finite.

    0: inputs at rest. 1: feedback. Then each input alone at either end, then all at once in every
    combination of ends (of the first three inputs).
    """
    rest_at_goal(w)
    held = OPENING_STAGES
    if number == 0:
        held = w.horizon[0]
    elif number == 1:
        held = 0
    for j in range(NU):
        end = opening_end(number, j)
        if end != 0.0 and math.isfinite(w.u_lower[j]) and math.isfinite(w.u_upper[j]):
            middle = 0.5 * (w.u_lower[j] + w.u_upper[j])
            reach = 0.5 * OPENING_SHARE * (w.u_upper[j] - w.u_lower[j])
            for i in range(min(held, w.horizon[0])):
                w.u[SECOND, i, j] = middle + end * reach
    return follow(w, held)


@compiled
def opening_end(number, j):
    """-1 or +1: the end of its box at which an opening holds input j; 0: at rest."""
    single = number - 2
    if single < 0:
        return 0.0
    if single < 2 * NU:
        if single // 2 != j:
            return 0.0
        return 1.0 if single % 2 == 0 else -1.0
    corner = single - 2 * NU
    return 1.0 if (corner >> min(j, 2)) % 2 == 0 else -1.0


@compiled
def extension(w, plan, stages):
    """Fill FIRST with a plan of fewer stages extended by the feedback; False if not finite."""
    rest_at_goal(w)
    for i in range(stages):
        for j in range(NU):
            w.u[SECOND, i, j] = w.u[plan, i, j]
    for j in range(NA):
        w.a[SECOND, j] = w.a[plan, j]
    return follow(w, stages)


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
            low, high = w.mu_h[KEPT, below, j], w.mu_h[KEPT, above, j]
            w.mu_h[WORKING, i, j] = (1.0 - share) * low + share * high
    for j in range(NA):
        w.a[SECOND, j] = w.a[KEPT, j]
    for j in range(NH):
        w.rho_h[WORKING, j] = w.rho_h[KEPT, j]
        w.residual_h[j] = math.inf
    for j in range(NE):
        w.mu_e[WORKING, j] = w.mu_e[KEPT, j]
        w.rho_e[WORKING, j] = w.rho_e[KEPT, j]
        w.residual_e[j] = math.inf
    return follow(w, N)


@compiled
def rest_at_goal(w):
    """Plan SECOND rests at the goal, inputs as near to 0 as the box allows."""
    for i in range(w.horizon[0] + 1):
        for r in range(NX):
            w.x[SECOND, i, r] = w.goal[r]
    for i in range(w.horizon[0]):
        for j in range(NU):
            w.u[SECOND, i, j] = min(max(0.0, w.u_lower[j]), w.u_upper[j])
    for j in range(NA):
        w.a[SECOND, j] = w.a_guess[j]


@compiled
def follow(w, held):
    """Roll out plan SECOND into FIRST, its inputs alone for the first ``held`` stages, then with
    the feedback to its states; False if the plan is not finite."""
    for i in range(w.horizon[0]):
        for j in range(NU):
            w.k[i, j] = 0.0
            for r in range(NS):
                w.K[i, j, r] = 0.0 if i < held else w.policy[j, r]
    for j in range(NA):
        w.k_a[j] = 0.0
    rollout(w, SECOND, FIRST, 0.0)
    return math.isfinite(w.value[FIRST, 0])
