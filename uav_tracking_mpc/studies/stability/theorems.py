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

"""Theorems 2 and 3 of the paper, quantity by quantity, and states that break what they need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.ingredients import (
    Excess,
    StabilityProblem,
    TerminalIngredients,
    directions,
    q_star,
    relative_eigenvalues,
)


@dataclass(frozen=True)
class Condition:
    """An inequality ``left >= right`` of the paper.

    Attributes:
        left: Its left side [-].
        right: Its right side [-].
    """

    left: float
    right: float

    @property
    def holds(self) -> bool:
        """Whether the inequality is true."""
        return bool(self.left >= self.right)

    def as_dict(self) -> dict[str, float | bool]:
        """For JSON."""
        return {"holds": self.holds, "left": self.left, "right": self.right}


@dataclass(frozen=True)
class TheoremQuantities:
    """Everything that Theorems 2 and 3 speak of, for one Lipschitz constant.

    Attributes:
        a_1: lambda_min(P) [-].
        a_2: lambda_max(P) [-]. V_f is |x|^2 in P_rho, so its bound needs rho a_2: another slip.
        sigma: (34) [-].
        xi: (52) [-].
        eta: (44) [-].
        contraction: |A_K|_P [-].
        lipschitz: L of (27), (31) [-].
        b: 2 L |A_K|_P + L^2 [-].
        tau: (45) [-].
        c_2: (47) [-].
        c_3: (53) [-].
        gamma: (38) [-].
        gamma_n: (55) [-].
        scaling: rho [-].
        horizon: N.
    """

    a_1: float
    a_2: float
    sigma: float
    xi: float
    eta: float
    contraction: float
    lipschitz: float
    b: float
    tau: float
    c_2: float
    c_3: float
    gamma: float
    gamma_n: float
    scaling: float
    horizon: int

    @property
    def theorem2(self) -> Condition:
        """(29): rho sigma >= b."""
        return Condition(self.scaling * self.sigma, self.b)

    @property
    def theorem3(self) -> Condition:
        """(41): xi + (rho - 1) sigma >= b."""
        return Condition(self.xi + (self.scaling - 1.0) * self.sigma, self.b)


def largest_lipschitz(contraction: float, allowance: float) -> float:
    """The L at which b reaches an allowance: root of L^2 + 2 L |A_K|_P = allowance.

    Args:
        contraction: |A_K|_P [-].
        allowance: Greatest b that a condition admits [-].
    """
    return float(np.sqrt(contraction**2 + allowance) - contraction)


def theorem_quantities(
    problem: StabilityProblem, ingredients: TerminalIngredients, lipschitz: float
) -> TheoremQuantities:
    """Evaluate Theorems 2 and 3.

    Args:
        problem: Q, R and N.
        ingredients: K, P and P_rho.
        lipschitz: L [-], (31), for the terminal level in question.
    """
    weight, scaling = ingredients.weight, ingredients.scaling
    horizon, star = problem.horizon, q_star(problem, ingredients.gain)
    a_1, *_, a_2 = map(float, np.linalg.eigvalsh(ingredients.riccati))
    sigma, *_, eta = map(float, relative_eigenvalues(star, weight))  # Z* of (34), (44)
    xi, *_ = map(float, relative_eigenvalues(problem.state_weight, weight))  # Z of (52)
    closed_loop = ingredients.closed_loop
    squares = relative_eigenvalues(closed_loop.T @ weight @ closed_loop, weight)
    contraction = float(np.sqrt(squares[-1]))  # (33)
    b = 2.0 * lipschitz * contraction + lipschitz**2
    a_3 = scaling * sigma - b  # (37)
    tau = b + contraction**2  # (45)
    c_2 = sum(eta * tau**j for j in range(horizon - 1)) + tau ** (horizon - 1)  # (47)
    c_3 = xi + (scaling - 1.0) * sigma - b  # (53)
    return TheoremQuantities(
        a_1=a_1,
        a_2=a_2,
        sigma=sigma,
        xi=xi,
        eta=eta,
        contraction=contraction,
        lipschitz=lipschitz,
        b=b,
        tau=tau,
        c_2=c_2,
        c_3=c_3,
        gamma=1.0 - a_3 / a_2,  # (38)-(39)
        gamma_n=1.0 - c_3 / c_2,  # (55)
        scaling=scaling,
        horizon=horizon,
    )


@dataclass(frozen=True)
class Violation:
    """A state on the edge of the bound.

    Attributes:
        level: x' P x there [-].
        state: x, shape (5,), error coordinates.
    """

    level: float
    state: NDArray[np.float64]


def lowest_violation(
    excess: Excess, ceiling: float, rays: int = 6000, starts: int = 16, seed: int = 0
) -> Violation | None:
    """The lowest level found at which the bound fails.

    Args:
        excess: Left side minus right side.
        ceiling: Greatest level to look at [-].
        rays: Directions tried.
        starts: Local descents from the best of them.
        seed: Of the random directions.

    Returns:
        None if no ray meets a violation below the ceiling.
    """
    rays_out = directions(excess.weight, rays, np.random.default_rng(seed))
    hits: NDArray[np.float64] = np.zeros((0, rays_out.shape[1]))
    for level in ceiling * np.geomspace(1e-3, 1.0, 40):
        states = np.sqrt(level) * rays_out
        values = excess(states)
        where = np.flatnonzero(values > 0.0)
        if where.size:
            hits = np.vstack([hits, states[where[np.argsort(-values[where])][:starts]]])
        if len(hits) >= starts:
            break
    best: Violation | None = None
    for hit in hits[:starts]:
        candidate = _descend(excess, hit)
        if best is None or candidate.level < best.level:
            best = candidate
    return best


def _descend(excess: Excess, hit: NDArray[np.float64]) -> Violation:
    """Minimise x'Px subject to excess(x) >= 0 from a violating state."""
    from scipy.optimize import minimize  # slow to load, and a controller never searches

    weight = excess.weight
    answer = minimize(
        lambda x: float(x @ weight @ x),
        hit,
        jac=lambda x: 2.0 * weight @ x,
        constraints=_not_below_zero(
            lambda x: excess.with_gradient(x)[0], lambda x: excess.with_gradient(x)[1]
        ),
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-13},
    )
    state = answer.x
    # Step outwards until the state violates the bound indeed, not only to the solver's tolerance.
    for stretch in (1.0, 1.0 + 1e-9, 1.0 + 1e-7, 1.0 + 1e-5, 1.0 + 1e-4):
        trial = stretch * state
        level = float(trial @ weight @ trial)
        if excess(trial[None])[0] > 0.0 and level > 1e-9 * float(hit @ weight @ hit):
            return Violation(level, trial)
    return Violation(float(hit @ weight @ hit), hit)


def _not_below_zero(value: Callable[..., Any], gradient: Callable[..., Any]) -> dict[str, Any]:
    """A constraint as SciPy takes it."""
    return {"type": "ineq", "fun": value, "jac": gradient}


def lipschitz_excess(
    problem: StabilityProblem, ingredients: TerminalIngredients, constant: float
) -> Excess:
    """|g(x)|_P^2 - constant^2 |x|_P^2 with g(x) = f(x, Kx) - A_K x: above 0 where (27) fails.

    Args:
        problem: The configuration.
        ingredients: K, P_rho and A_K.
        constant: L [-].
    """
    weight, linear = ingredients.weight, ingredients.closed_loop
    return Excess(problem.dynamics(), ingredients.gain, weight, constant**2 * weight, linear)


def largest_ratio(
    excess: Excess, level: float, rays: int = 6000, starts: int = 12, seed: int = 0
) -> Violation:
    """State of x'Px <= level with the largest |F(x)|_P / |x|_P.

    Args:
        excess: |F|_P^2, so made with N = 0.
        level: varrho [-].
        rays: Directions tried.
        starts: Local ascents from the best of them.
        seed: Of the random directions.

    Returns:
        The ratio as :attr:`Violation.level`, and the state.
    """
    weight = excess.weight
    samples = directions(weight, rays, np.random.default_rng(seed))
    states = np.vstack([np.sqrt(level * part) * samples for part in (1.0, 0.7, 0.4)])
    from scipy.optimize import minimize

    heights = np.einsum("ki,ij,kj->k", states, weight, states)
    ratios = np.nan_to_num(excess(states) / heights, nan=-np.inf, posinf=-np.inf)

    def ratio(x: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        value, gradient = excess.with_gradient(x)
        height = float(x @ weight @ x)
        return -value / height, -gradient / height + 2.0 * value / height**2 * weight @ x

    best = Violation(0.0, states[0])
    for index in np.argsort(-ratios)[:starts]:
        answer = minimize(
            ratio,
            states[index],
            jac=True,
            constraints=_not_below_zero(
                lambda x: level - float(x @ weight @ x), lambda x: -2.0 * weight @ x
            ),
            method="SLSQP",
            options={"maxiter": 200, "ftol": 1e-14},
        )
        x = answer.x * min(1.0, np.sqrt(level / float(answer.x @ weight @ answer.x)))
        value = -ratio(x)[0]
        if np.isfinite(value) and value > best.level**2:
            best = Violation(float(np.sqrt(value)), x)
    return best
