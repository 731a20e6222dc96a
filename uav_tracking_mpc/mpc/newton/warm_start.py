"""A warm start: the kept plan moved on in time."""

import math

from .compilation import compiled
from .stage import NA, NE, NH, NS, NU, N
from .workspace import KEPT, SECOND, WORKING


@compiled
def move_on(w, stages):
    """Inputs, decisions and multipliers of row KEPT, ``stages`` later, into row SECOND.

    Between samples by linear interpolation; the last is held. The gains are 0: a rollout repeats
    the inputs.

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
            w.k[i, j] = 0.0
            for r in range(NS):
                w.K[i, j, r] = 0.0
        for j in range(NH):
            low, high = w.mu_h[KEPT, below, j], w.mu_h[KEPT, above, j]
            w.mu_h[WORKING, i, j] = (1.0 - share) * low + share * high
    for j in range(NA):
        w.a[SECOND, j] = w.a[KEPT, j]
        w.k_a[j] = 0.0
    for j in range(NH):
        w.rho_h[WORKING, j] = w.rho_h[KEPT, j]
        w.residual_h[j] = math.inf
    for j in range(NE):
        w.mu_e[WORKING, j] = w.mu_e[KEPT, j]
        w.rho_e[WORKING, j] = w.rho_e[KEPT, j]
        w.residual_e[j] = math.inf
