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

r"""From the last stage to the first: costates, Riccati recursion, Newton step.

With the quadratic model of the value function of stage i + 1, V, v, the model of stage i in
w = (s, u) is

.. math::

    Q = L_{ww} + h_w^T D h_w + F^T V F, \qquad q = L_w + F^T (v - \lambda)

(one call of generated code). Minimised over the inputs of the stage, within their box, it gives
du = k + K ds and the model of stage i,

.. math::

    V = Q_{ss} + Q_{su} K, \qquad v = q_s + Q_{su} k.

L_ww holds the curvature of the dynamics along the costate, lambda_i = L_s: the step is Newton's,
not Gauss-Newton's. The u-part of L_w is the gradient of the whole problem, so the sweep that
makes the step also measures the KKT residual of the plan.

The small model of a stage, y'Hy/2 + g'y, is minimised over its box by an active set: solve over the
free components, clamp those that leave the box, free again a clamped one whose slope points inside.
A Hessian that is not positive definite on the free components is made so while it is factorised, by
a change of just those diagonal elements whose pivots are negative: to their absolute value (Gill,
Murray, Wright: Practical Optimization, 4.4.2.2). Unlike a shift tau I, that leaves the other
components their Newton step, however different their scales.
"""

import math

from .compiling import compiled
from .lagrangian import multipliers
from .stage import NA, NS, NU, NX, stage_quadratic, terminal_quadratic

PIVOT = 1e-10  # -, smallest accepted pivot, relative to its diagonal element
REPLACED, SMALLEST = 1e-3, 1e-6  # -, what at least replaces another: relative to that, and at all


@compiled
def minimise_over_box(w, size, damping):
    """Solve for w.step from w.hessian, w.slope, w.lower, w.upper.

    Leaves the components that are free in w.free (1 or 0) and the factor of the free block in
    w.factor; damping has been added to the diagonal of w.hessian.

    Args:
        w: Workspace.
        size: Number of components.
        damping: tau to begin with.

    Returns:
        Change of the merit that the model predicts, y'(g + H y / 2).
    """
    for j in range(size):
        w.hessian[j, j] += damping
        w.step[j] = 0.0
        outward = (w.lower[j] >= 0.0 and w.slope[j] > 0.0) or (
            w.upper[j] <= 0.0 and w.slope[j] < 0.0
        )
        w.free[j] = 0.0 if outward else 1.0
    for _ in range(4 * size + 2):
        factorise(w, size)
        newton_step(w, size)
        if clamp(w, size):
            continue
        if not release(w, size):
            break
    change = 0.0
    for r in range(size):
        slope = w.slope[r]
        for c in range(size):
            slope += 0.5 * w.hessian[r, c] * w.step[c]
        change += w.step[r] * slope
    return change


@compiled
def factorise(w, size):
    """Factor L of H = L L' on the free components, identity on the others.

    H is made positive definite where it is not.

    Args:
        w: Workspace.
        size: Number of components.
    """
    for r in range(size):
        for c in range(r + 1):
            entry = w.hessian[r, c] * w.free[r] * w.free[c]
            if r == c:
                entry += 1.0 - w.free[r]
            for j in range(c):
                entry -= w.factor[r, j] * w.factor[c, j]
            if r > c:
                w.factor[r, c] = entry / w.factor[c, c]
                continue
            diagonal = abs(w.hessian[r, r])
            if w.free[r] == 1.0 and not entry > PIVOT * diagonal:
                pivot = max(-entry, REPLACED * diagonal, SMALLEST)
                w.hessian[r, r] += pivot - entry
                entry = pivot
                w.shifts[0] += 1.0
            w.factor[r, r] = math.sqrt(entry)


@compiled
def solve_factor(w, size, y):
    """Replace a vector by its solution: y becomes (L L')^-1 y.

    Args:
        w: Workspace, with L.
        size: Number of components.
        y: Right-hand side; overwritten.
    """
    for r in range(size):
        for j in range(r):
            y[r] -= w.factor[r, j] * y[j]
        y[r] /= w.factor[r, r]
    for r in range(size - 1, -1, -1):
        for j in range(r + 1, size):
            y[r] -= w.factor[j, r] * y[j]
        y[r] /= w.factor[r, r]


@compiled
def newton_step(w, size):
    """Minimise over the free components, y_F = -H_FF^-1 (g_F + H_FC y_C); clamped ones stay.

    Args:
        w: Workspace.
        size: Number of components.
    """
    for j in range(size):
        if w.free[j] == 0.0:
            continue
        slope = w.slope[j]
        for c in range(size):
            if w.free[c] == 0.0:
                slope += w.hessian[j, c] * w.step[c]
        w.step[j] = -slope
    # rows of clamped components are rows of the identity: they pass through unchanged
    solve_factor(w, size, w.step)


@compiled
def clamp(w, size):
    """Clamp free components that left the box; True if there were any.

    Args:
        w: Workspace.
        size: Number of components.
    """
    clamped = False
    for j in range(size):
        if w.free[j] == 1.0 and not w.lower[j] <= w.step[j] <= w.upper[j]:
            w.step[j] = min(max(w.step[j], w.lower[j]), w.upper[j])
            w.free[j] = 0.0
            clamped = True
    return clamped


@compiled
def release(w, size):
    """Free the clamped component whose slope points inside most steeply; False if none does.

    Args:
        w: Workspace.
        size: Number of components.
    """
    steepest, chosen = 0.0, -1
    for j in range(size):
        if w.free[j] == 1.0:
            continue
        slope = w.slope[j]
        for c in range(size):
            slope += w.hessian[j, c] * w.step[c]
        inward = -slope if w.step[j] <= w.lower[j] else slope
        if inward > steepest:
            steepest, chosen = inward, j
    if chosen >= 0:
        w.free[chosen] = 1.0
    return chosen >= 0


@compiled
def backward_sweep(w, now, curvature, damping):
    """Newton step k, K, k_a at a plan.

    Args:
        w: Workspace.
        now: Which plan.
        curvature: 1 for the exact Hessian of the dynamics, 0 for Gauss-Newton.
        damping: Levenberg-Marquardt term on the inputs.

    Returns:
        stationarity: Largest component of the gradient that no bound holds.
        scale: What it is relative to: 1 + the largest gradient before projection.
        residual: max |m - mu| / rho of the constraints.
        predicted: Change of the merit that the quadratic model predicts, <= 0.
    """
    w.curvature[0] = curvature
    w.shifts[0] = 0.0
    end = w.horizon[0]
    residual = multipliers(w, now, end)
    terminal_quadratic((w.x[now, end], w.a[now], w.p[end], w.m, w.d), (w.V, w.v))
    for r in range(NS):
        w.costate[r] = w.v[r]
    stationarity = scale = predicted = 0.0
    for i in range(end - 1, -1, -1):
        residual = max(residual, multipliers(w, now, i))
        stage_quadratic(
            (
                w.x[now, i], w.u[now, i], w.a[now], w.p[i],
                w.costate, w.curvature, w.m, w.d, w.V, w.v,
            ),
            (w.Q, w.q, w.gradient),
        )  # fmt: skip
        for r in range(NS):
            w.costate[r] = w.gradient[r]  # lambda_i = L_s
        for j in range(NU):
            slope = w.gradient[NS + j]
            scale = max(scale, abs(slope))
            if not held(slope, w.u[now, i, j], w.u_lower[j], w.u_upper[j]):
                stationarity = max(stationarity, abs(slope))
        predicted += minimise_stage(w, now, i, damping)
        value_function(w, i)
    for j in range(NA):
        slope = w.costate[NX + j]
        scale = max(scale, abs(slope))
        if not held(slope, w.a[now, j], w.a_lower[j], w.a_upper[j]):
            stationarity = max(stationarity, abs(slope))
    predicted += minimise_decision(w, now, damping)
    return stationarity, 1.0 + scale, residual, predicted


@compiled
def held(slope, value, lower, upper):
    """Whether a ``value`` is at its ``lower`` or ``upper`` bound and ``slope`` holds it there."""
    return (slope >= 0.0 and value <= lower) or (slope <= 0.0 and value >= upper)


@compiled
def minimise_stage(w, now, i, damping):
    """Step k and gain K of one stage, from its Q and q.

    Args:
        w: Workspace.
        now: The plan that the step starts from.
        i: Stage.
        damping: Levenberg-Marquardt term on the inputs.

    Returns:
        Change of the merit that the model predicts.
    """
    for r in range(NU):
        for c in range(r, NU):
            w.hessian[r, c] = w.hessian[c, r] = w.Q[NS + r, NS + c]
        w.slope[r] = w.q[NS + r]
        w.lower[r] = w.u_lower[r] - w.u[now, i, r]
        w.upper[r] = w.u_upper[r] - w.u[now, i, r]
    change = minimise_over_box(w, NU, damping)
    for r in range(NU):
        w.k[i, r] = w.step[r]
    for c in range(NS):  # K = -Q_uu^-1 Q_us on the free inputs, 0 on the others
        for r in range(NU):
            w.step[r] = -w.Q[c, NS + r] * w.free[r]
        solve_factor(w, NU, w.step)
        for r in range(NU):
            w.K[i, r, c] = w.step[r]
    return change


@compiled
def value_function(w, i):
    """Value function at stage ``i`` of the workspace ``w``: V = Q_ss + Q_su K, v = q_s + Q_su k."""
    for r in range(NS):
        for c in range(r, NS):
            entry = w.Q[r, c]
            for j in range(NU):
                entry += w.Q[r, NS + j] * w.K[i, j, c]
            w.V[r, c] = entry
        entry = w.q[r]
        for j in range(NU):
            entry += w.Q[r, NS + j] * w.k[i, j]
        w.v[r] = entry


@compiled
def minimise_decision(w, now, damping):
    """Step k_a of the decisions: the first state is given, so they minimise V of stage 0 alone.

    Args:
        w: Workspace.
        now: The plan that the step starts from.
        damping: Levenberg-Marquardt term on the decisions.

    Returns:
        Change of the merit that the model predicts.
    """
    if NA == 0:
        return 0.0
    for r in range(NA):
        for c in range(r, NA):
            w.hessian[r, c] = w.hessian[c, r] = w.V[NX + r, NX + c]
        w.slope[r] = w.v[NX + r]
        w.lower[r] = w.a_lower[r] - w.a[now, r]
        w.upper[r] = w.a_upper[r] - w.a[now, r]
    change = minimise_over_box(w, NA, damping)
    for r in range(NA):
        w.k_a[r] = w.step[r]
    return change


@compiled
def decision_feedback(w, now):
    """Add to k_a what the first state's change asks for: -V_aa^-1 V_ax dx on free decisions.

    Args:
        w: Workspace, with the value function of stage 0 and what minimised it.
        now: The plan whose first state the new one is compared with.
    """
    if NA == 0:
        return
    for r in range(NA):
        w.step[r] = 0.0
        for c in range(NX):
            w.step[r] -= w.free[r] * w.V[c, NX + r] * (w.x_0[c] - w.x[now, 0, c])
    solve_factor(w, NA, w.step)
    for r in range(NA):
        w.k_a[r] += w.step[r]
