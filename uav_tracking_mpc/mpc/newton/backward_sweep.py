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
"""

from .input_box import minimise_over_box, solve_factor
from .multipliers import multipliers
from .numba_options import compiled
from .stage import NA, NS, NU, NX, stage_quadratic, terminal_quadratic


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
    minimise_over_box(w, NU, damping)
    change = 0.0
    for r in range(NU):
        w.k[i, r] = w.step[r]
        change += predicted_change(w, NU, r)
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
    minimise_over_box(w, NA, damping)
    change = 0.0
    for r in range(NA):
        w.k_a[r] = w.step[r]
        change += predicted_change(w, NA, r)
    return change


@compiled
def predicted_change(w, size, r):
    """Share of component ``r`` in the change of the model, y_r (g + H y / 2)_r, ``w`` holding all.

    Args:
        w: Workspace.
        size: Number of components.
        r: Component.
    """
    slope = w.slope[r]
    for c in range(size):
        slope += 0.5 * w.hessian[r, c] * w.step[c]
    return w.step[r] * slope
