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

r"""The quadratic program of one stage: a small model minimised over a box.

.. math::

    \min_{y} \; \tfrac12 y^T H y + g^T y, \qquad lower \le y \le upper

by an active set: solve over the free components, clamp those that leave the box, free again a
clamped one whose slope points inside. A Hessian that is not positive definite on the free
components is made so while it is factorised, by a change of just those diagonal elements whose
pivots are negative: to their absolute value (Gill, Murray, Wright: Practical Optimization,
4.4.2.2). Unlike a shift tau I, that leaves the other components their Newton step, however
different their scales.
"""

import math

from .numba_options import compiled

PIVOT = 1e-10  # smallest accepted pivot, relative to its diagonal element
REPLACED, SMALLEST = 1e-3, 1e-6  # what at least replaces another: relative to that, and at all


@compiled
def minimise_over_box(w, size, damping):
    """Solve for w.step from w.hessian, w.slope, w.lower, w.upper.

    Leaves the components that are free in w.free (1 or 0) and the factor of the free block in
    w.factor; damping has been added to the diagonal of w.hessian.

    Args:
        w: Workspace.
        size: Number of components.
        damping: tau to begin with.
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
