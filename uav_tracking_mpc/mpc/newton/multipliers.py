r"""Augmented Lagrangian: a constraint c as a term of the merit.

Every constraint is an interval of its multiplier: [0, inf) for a hard inequality c <= 0,
[0, penalty] for a soft one with exact L1 penalty, (-inf, inf) for an equality. With estimate mu and
weight rho the term is

.. math::

    \psi(c) = \max_{m \in [m_{lo}, m_{up}]} \; m c - (m - \mu)^2 / (2 \rho),

attained at m = clip(mu + rho c). It is once differentiable with psi' = m and psi'' = rho where m is
inside its interval, else 0. At a fixed point m = mu the interval says all: feasible and
complementary if hard; mu = penalty exactly where a soft one is violated. So |m - mu| / rho measures
feasibility and complementarity together, in the units of c.
"""

from .numba_options import compiled
from .stage import NH
from .workspace import WORKING

WEIGHT_LIMIT, WEIGHT_GROWTH = 1e10, 10.0
SMALL = 1e-7  # residuals below are met: their weights stay
PROGRESS = 0.25  # a residual that falls by less than this makes its weight grow


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
def augmented_term(c, mu, rho, lower, upper):
    """Term psi(c) of the augmented Lagrangian.

    Args:
        c: Value of the constraint.
        mu: Estimate of its multiplier.
        rho: Weight.
        lower: Least value of the multiplier.
        upper: Greatest.
    """
    m = multiplier(c, mu, rho, lower, upper)
    return m * c - (m - mu) ** 2 / (2.0 * rho)


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
def stage_multipliers(w, now, i):
    """Multipliers m and psi'' of the inequalities of one stage, into m_h and d_h.

    Args:
        w: Workspace.
        now: Row of the plan.
        i: Stage.

    Returns:
        Largest |m - mu| / rho of them.
    """
    residual = 0.0
    for j in range(NH):
        rho, mu = w.rho_h[WORKING, j], w.mu_h[WORKING, i, j]
        estimate = mu + rho * w.h[now, i, j]
        m = min(max(estimate, w.m_h_lower[j]), w.m_h_upper[j])
        w.m_h[j] = m
        w.d_h[j] = rho if m == estimate else 0.0
        residual = max(residual, abs(m - mu) / rho)
    return residual


@compiled
def terminal_multipliers(w, now):
    """Multipliers m and psi'' of the terminal constraints, into m_e and d_e.

    Args:
        w: Workspace.
        now: Row of the plan.

    Returns:
        Largest |m - mu| / rho of them.
    """
    residual = 0.0
    for j in range(w.ends[0]):
        rho, mu = w.rho_e[WORKING, j], w.mu_e[WORKING, j]
        estimate = mu + rho * w.e[now, j]
        m = min(max(estimate, w.m_e_lower[j]), w.m_e_upper[j])
        w.m_e[j] = m
        w.d_e[j] = rho if m == estimate else 0.0
        residual = max(residual, abs(m - mu) / rho)
    return residual


@compiled
def constraint_residual(w, now):
    """Largest |m - mu| / rho of all constraints.

    Args:
        w: Workspace.
        now: Row of the plan.
    """
    residual = terminal_multipliers(w, now)
    for i in range(w.horizon[0]):
        residual = max(residual, stage_multipliers(w, now, i))
    return residual


@compiled
def merit(w, now):
    """Augmented Lagrangian of a plan: its smooth cost and psi of every constraint.

    Args:
        w: Workspace.
        now: Row of the plan.
    """
    total = w.value[now, 0]
    for i in range(w.horizon[0]):
        for j in range(NH):
            total += augmented_term(
                w.h[now, i, j],
                w.mu_h[WORKING, i, j],
                w.rho_h[WORKING, j],
                w.m_h_lower[j],
                w.m_h_upper[j],
            )
    for j in range(w.ends[0]):
        total += augmented_term(
            w.e[now, j],
            w.mu_e[WORKING, j],
            w.rho_e[WORKING, j],
            w.m_e_lower[j],
            w.m_e_upper[j],
        )
    return total


@compiled
def exact_cost(w, now):
    """Cost with exact penalties and largest hard violation of a plan, into its value.

    Args:
        w: Workspace.
        now: Row of the plan.
    """
    cost, violation = w.value[now, 0], 0.0
    for i in range(w.horizon[0]):
        for j in range(NH):
            cost += exact_term(w.h[now, i, j], w.m_h_lower[j], w.m_h_upper[j])
            violation = max(
                violation, hard_violation(w.h[now, i, j], w.m_h_lower[j], w.m_h_upper[j])
            )
    for j in range(w.ends[0]):
        cost += exact_term(w.e[now, j], w.m_e_lower[j], w.m_e_upper[j])
        violation = max(violation, hard_violation(w.e[now, j], w.m_e_lower[j], w.m_e_upper[j]))
    w.value[now, 1] = cost
    w.value[now, 2] = violation


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
    for j in range(NH):
        rho, residual = w.rho_h[WORKING, j], 0.0
        for i in range(w.horizon[0]):
            mu = w.mu_h[WORKING, i, j]
            m = multiplier(w.h[now, i, j], mu, rho, w.m_h_lower[j], w.m_h_upper[j])
            residual = max(residual, abs(m - mu) / rho)
            w.mu_h[WORKING, i, j] = m
        if residual > max(PROGRESS * w.residual_h[j], SMALL):
            room = room and rho < WEIGHT_LIMIT
            w.rho_h[WORKING, j] = min(rho * WEIGHT_GROWTH, WEIGHT_LIMIT)
        w.residual_h[j] = residual
    for j in range(w.ends[0]):
        rho, mu = w.rho_e[WORKING, j], w.mu_e[WORKING, j]
        m = multiplier(w.e[now, j], mu, rho, w.m_e_lower[j], w.m_e_upper[j])
        residual = abs(m - mu) / rho
        w.mu_e[WORKING, j] = m
        if residual > max(PROGRESS * w.residual_e[j], SMALL):
            room = room and rho < WEIGHT_LIMIT
            w.rho_e[WORKING, j] = min(rho * WEIGHT_GROWTH, WEIGHT_LIMIT)
        w.residual_e[j] = residual
    return room
