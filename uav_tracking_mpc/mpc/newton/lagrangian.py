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

r"""Augmented Lagrangian of a rollout: a constraint c as a term of the merit.

Every constraint is an interval of its multiplier: [0, inf) for a hard inequality c <= 0,
[0, penalty] for a soft one with exact L1 penalty, (-inf, inf) for an equality. With estimate mu and
weight rho the term is

.. math::

    \psi(c) = \max_{m \in [m_{lo}, m_{up}]} \; m c - (m - \mu)^2 / (2 \rho),

attained at m = clip(mu + rho c). It is once differentiable with psi' = m and psi'' = rho where m is
inside its interval, else 0. At a fixed point m = mu the interval says all: feasible and
complementary if hard; mu = penalty exactly where a soft one is violated. So |m - mu| / rho measures
feasibility and complementarity together, in the units of c.

Stage i has the inequalities h, the end the constraints e; both are held in the same arrays, with
the end as the stage after the last. Weights and intervals are the same at every stage, so they have
one row for the stages and one for the end.

What is measured is a rollout, so that the dynamics hold exactly at every iterate:

.. math::

    s_0^+ = (x_0, a + \alpha k_a), \quad
    u_i^+ = \mathrm{clip}(u_i + \alpha k_i + K_i (s_i^+ - s_i)), \quad
    x_{i+1}^+ = f(x_i^+, u_i^+, p_i, a^+)
"""

import math

from .compiling import compiled
from .stage import NA, NH, NS, NU, NX, stage_values, terminal_values
from .workspace import END, NC, ROWS, STAGES, WORKING

WEIGHT_LIMIT, WEIGHT_GROWTH = 1e10, 10.0  # -, greatest penalty weight, and a factor of its growth
SMALL = 1e-7  # -, tolerance of residuals: below it they are met
PROGRESS = 0.25  # -, share of a residual's fall below which its penalty grows


@compiled
def multiplier(c, mu, rho, lower, upper):
    """Multiplier m of a constraint, clip(mu + rho c, lower, upper).

    Args:
        c: Value of the constraint.
        mu: Estimate of its multiplier.
        rho: Weight.
        lower: Least value of the multiplier.
        upper: Greatest.
    """
    return min(max(mu + rho * c, lower), upper)


@compiled
def exact_term(c, lower, upper):
    """What a constraint adds to the cost itself: the L1 penalty of a soft one, else 0.

    Args:
        c: Value of the constraint.
        lower: Least value of its multiplier.
        upper: Greatest; finite for a soft one.
    """
    return upper * c if lower == 0.0 and upper < 1e300 and c > 0.0 else 0.0


@compiled
def hard_violation(c, lower, upper):
    """Violation of a hard constraint; 0 for a soft one.

    Args:
        c: Value of the constraint.
        lower: Least value of its multiplier.
        upper: Greatest; finite for a soft one.
    """
    if upper < 1e300:
        return 0.0
    return abs(c) if lower < 0.0 else max(0.0, c)


@compiled
def row_of(w, i):
    """Row of weights and intervals for stage ``i`` of the workspace ``w``."""
    return END if i == w.horizon[0] else STAGES


@compiled
def number_of(w, row):
    """Number of constraints of a stage, or of the end, by the ``row`` of the workspace ``w``."""
    return w.ends[0] if row == END else NH


@compiled
def multipliers(w, now, i):
    """Multipliers m and psi'' of the constraints of one stage, or of the end, into m and d.

    Args:
        w: Workspace.
        now: Row of the plan.
        i: Stage; the horizon's length for the end.

    Returns:
        Largest |m - mu| / rho of them.
    """
    row = row_of(w, i)
    count = number_of(w, row)
    residual = 0.0
    for j in range(NC):
        w.m[j] = w.d[j] = 0.0
        if j < count:
            rho, mu = w.rho[WORKING, row, j], w.mu[WORKING, i, j]
            estimate = mu + rho * w.c[now, i, j]
            w.m[j] = min(max(estimate, w.m_lower[row, j]), w.m_upper[row, j])
            w.d[j] = rho if w.m[j] == estimate else 0.0
            residual = max(residual, abs(w.m[j] - mu) / rho)
    return residual


@compiled
def merit(w, now):
    """Augmented Lagrangian of a plan: its smooth cost and psi of every constraint.

    Into the plan's value go its cost with exact penalties, its largest hard violation, inf for a
    cost that is not finite, and the largest |m - mu| / rho of all constraints.

    Args:
        w: Workspace.
        now: Row of the plan.
    """
    total = cost = w.value[now, 0]
    violation = residual = 0.0
    for i in range(w.horizon[0] + 1):
        row = row_of(w, i)
        for j in range(number_of(w, row)):
            c, lower, upper = w.c[now, i, j], w.m_lower[row, j], w.m_upper[row, j]
            mu, rho = w.mu[WORKING, i, j], w.rho[WORKING, row, j]
            m = multiplier(c, mu, rho, lower, upper)
            total += m * c - (m - mu) ** 2 / (2.0 * rho)
            cost += exact_term(c, lower, upper)
            violation = max(violation, hard_violation(c, lower, upper))
            residual = max(residual, abs(m - mu) / rho)
    w.value[now, 1] = cost
    w.value[now, 2] = violation if math.isfinite(cost) else math.inf
    w.value[now, 3] = residual
    return total


@compiled
def update_multipliers(w, now):
    """Take m as the new estimate mu of every constraint; weights of slow ones grow.

    Args:
        w: Workspace.
        now: Row of the plan.

    Returns:
        Whether all weights were below their limit.
    """
    room = True
    end = w.horizon[0]
    for row in range(ROWS):
        first, after = (end, end + 1) if row == END else (0, end)
        for j in range(number_of(w, row)):
            rho, residual = w.rho[WORKING, row, j], 0.0
            for i in range(first, after):
                mu = w.mu[WORKING, i, j]
                m = multiplier(w.c[now, i, j], mu, rho, w.m_lower[row, j], w.m_upper[row, j])
                residual = max(residual, abs(m - mu) / rho)
                w.mu[WORKING, i, j] = m
            if residual > max(PROGRESS * w.residual[row, j], SMALL):
                room = room and rho < WEIGHT_LIMIT
                w.rho[WORKING, row, j] = min(rho * WEIGHT_GROWTH, WEIGHT_LIMIT)
            w.residual[row, j] = residual
    return room


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
