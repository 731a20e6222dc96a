r"""The quadratic program of one stage: a small model minimised over a box.

.. math::

    \min_{y} \; \tfrac12 y^T H y + g^T y, \qquad lower \le y \le upper

by an active set: solve over the free components, clamp those that leave the box, free again a
clamped one whose slope points inside. A Hessian that is not positive definite on the free
components is made so by tau I (Levenberg-Marquardt), tau growing until its Cholesky
factorisation exists.
"""

import math

from .compilation import compiled

ATTEMPTS = 20
PIVOT = 1e-4  # smallest accepted pivot, relative to the largest diagonal element


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
        for _ in range(ATTEMPTS):  # bounded: a Hessian that is not finite never factorises
            if factorise(w, size):
                break
            increase = max(10.0 * damping, 1e-3 * largest_diagonal(w, size))
            damping += increase
            w.shifts[0] += 1.0
            for j in range(size):
                w.hessian[j, j] += increase
        newton_step(w, size)
        if clamp(w, size):
            continue
        if not release(w, size):
            break


@compiled
def largest_diagonal(w, size):
    """Max |H_jj|, at least 1e-6."""
    largest = 1e-6
    for j in range(size):
        largest = max(largest, abs(w.hessian[j, j]))
    return largest


@compiled
def factorise(w, size):
    """L L' = H on the free components, identity on the others; False if not positive definite."""
    least = PIVOT * largest_diagonal(w, size)
    for r in range(size):
        for c in range(r + 1):
            entry = w.hessian[r, c] * w.free[r] * w.free[c]
            if r == c:
                entry += 1.0 - w.free[r]
            for j in range(c):
                entry -= w.factor[r, j] * w.factor[c, j]
            if r > c:
                w.factor[r, c] = entry / w.factor[c, c]
            elif entry > least or w.free[r] == 0.0:
                w.factor[r, r] = math.sqrt(entry)
            else:
                return False
    return True


@compiled
def solve_factor(w, size, y):
    """Y <- (L L')^-1 y."""
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
    """y_F = -H_FF^-1 (g_F + H_FC y_C); clamped components stay."""
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
    """Clamp free components that left the box; True if there were any."""
    clamped = False
    for j in range(size):
        if w.free[j] == 1.0 and not w.lower[j] <= w.step[j] <= w.upper[j]:
            w.step[j] = min(max(w.step[j], w.lower[j]), w.upper[j])
            w.free[j] = 0.0
            clamped = True
    return clamped


@compiled
def release(w, size):
    """Free the clamped component whose slope points inside most steeply; False if none does."""
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
