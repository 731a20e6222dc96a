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

"""Search for states that break a quadratic bound: what a proof can at most reach.

The bound |f(x, Kx) - C x|_P^2 <= x' N x (see ``quadratic_bound``) holds near the origin when it
holds for the linearisation. Here the lowest level x'Px on which it fails is looked for: many rays
from the origin, then local descent from the best hits. What is found is a state, so it is a fact;
that nothing is found below it is only an observation, which the proof turns into a theorem.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Violation:
    """A state on the edge of the bound.

    Attributes:
        level: x' P x there [-].
        state: x, shape (5,), error coordinates.
    """

    level: float
    state: NDArray[np.float64]


class Excess:
    """|f(x, Kx) - C x|_P^2 - x' N x in floating point, with its gradient.

    Args:
        dynamics: f(x, u).
        gain: K, shape (nu, nx).
        weight: P, shape (nx, nx).
        right: N, shape (nx, nx).
        subtracted: C, shape (nx, nx), or None for 0.
    """

    def __init__(
        self,
        dynamics: ca.Function,
        gain: NDArray[np.float64],
        weight: NDArray[np.float64],
        right: NDArray[np.float64],
        subtracted: NDArray[np.float64] | None = None,
    ) -> None:
        self.weight = weight
        x = ca.SX.sym("x", len(weight))
        image = dynamics(x, ca.DM(gain) @ x)
        if subtracted is not None:
            image = image - ca.DM(subtracted) @ x
        left, right_side = ca.bilin(ca.DM(weight), image, image), ca.bilin(ca.DM(right), x, x)
        excess = left - right_side
        self._value = ca.Function("excess", [x], [excess])
        self._both = ca.Function("excess_gradient", [x], [excess, ca.gradient(excess, x)])

    def __call__(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values, shape (n,), at ``states`` of shape (n, 5); nan outside the model's domain."""
        return np.array(self._value(states.T)).ravel()

    def with_gradient(self, state: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        """Value and gradient, shape (5,), at one ``state`` of shape (5,)."""
        value, gradient = self._both(state)
        return float(value), np.array(gradient).ravel()


def directions(
    weight: NDArray[np.float64], count: int, generator: np.random.Generator
) -> NDArray[np.float64]:
    """States uniformly spread over x'Px = 1, shape (count, 5).

    Args:
        weight: P, shape (5, 5).
        count: How many.
        generator: Source of randomness.
    """
    whitened = generator.normal(size=(count, len(weight)))
    whitened /= np.linalg.norm(whitened, axis=1, keepdims=True)
    return whitened @ np.linalg.inv(np.linalg.cholesky(weight))


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
