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

r"""Forward simulation under a step: the dynamics hold exactly at every iterate.

.. math::

    s_0^+ = (x_0, a + \alpha k_a), \quad
    u_i^+ = \mathrm{clip}(u_i + \alpha k_i + K_i (s_i^+ - s_i)), \quad
    x_{i+1}^+ = f(x_i^+, u_i^+, p_i, a^+)
"""

from .numba_options import compiled
from .stage import NA, NS, NU, NX, stage_values, terminal_values


@compiled
def rollout(w, now, trial, length):
    """Fill one plan by following the step from another.

    Args:
        w: Workspace, with the step k, K, k_a.
        now: Row of the plan that the step starts from.
        trial: Row to fill.
        length: alpha, the fraction of the step to take.
    """
    end = w.horizon[0]
    for j in range(NA):
        a = w.a[now, j] + length * w.k_a[j]
        w.a[trial, j] = min(max(a, w.a_lower[j]), w.a_upper[j])
        w.feedback[NX + j] = w.a[trial, j] - w.a[now, j]
    for r in range(NX):
        w.x[trial, 0, r] = w.x_0[r]
    cost = 0.0
    for i in range(end):
        for r in range(NX):
            w.feedback[r] = w.x[trial, i, r] - w.x[now, i, r]
        for j in range(NU):
            u = w.u[now, i, j] + length * w.k[i, j]
            for r in range(NS):
                u += w.K[i, j, r] * w.feedback[r]
            w.u[trial, i, j] = min(max(u, w.u_lower[j]), w.u_upper[j])
        stage_values(
            (w.x[trial, i], w.u[trial, i], w.a[trial], w.p[i]),
            (w.x[trial, i + 1], w.l, w.c[trial, i]),
        )
        cost += w.l[0]
    terminal_values((w.x[trial, end], w.a[trial], w.p[end]), (w.l, w.c[trial, end]))
    w.value[trial, 0] = cost + w.l[0]
