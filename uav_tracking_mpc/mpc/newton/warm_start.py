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

"""A warm start: the kept plan moved on in time."""

import math

from .numba_options import compiled
from .stage import NA, NS, NU, N, continuation
from .workspace import KEPT, NC, ROWS, SECOND, WORKING

WEIGHT_KEPT = 1e3  # largest penalty weight to begin with


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
    for j in range(NC):
        w.mu[WORKING, N, j] = w.mu[KEPT, N, j]
        for row in range(ROWS):
            w.rho[WORKING, row, j] = min(w.rho[KEPT, row, j], WEIGHT_KEPT)
            w.residual[row, j] = math.inf
