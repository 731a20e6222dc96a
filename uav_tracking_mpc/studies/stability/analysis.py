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

"""Section 5 of the paper for one configuration: the theorems, their levels, and the direct proof.

Theorems 2 and 3 are evaluated quantity by quantity, and states are searched that break what they
need. Four levels varrho of the ellipsoid x'P_rho x <= varrho come out of it: up to which Theorem 3
can be applied, up to which the decrease itself is proved, up to which U allows, and the certified
one, at which the direct condition holds in all its parts. Every level is proved at the value that
is reported; the smallest level at which a counterexample is known is reported beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.studies.stability.proof import (
    BOXES,
    DirectCondition,
    Limit,
    Proof,
    allowed_level,
    decrease,
    limits,
    lipschitz_bound,
    prove,
    prove_direct_condition,
)
from uav_tracking_mpc.studies.study import Say
from uav_tracking_mpc.terminal.ingredients import (
    Excess,
    StabilityProblem,
    TerminalIngredients,
    decrease_excess,
    directions,
    q_star,
    relative_eigenvalues,
)
from uav_tracking_mpc.terminal.quadratic_bound import QuadraticBound

ASCENTS = 12  # starts of a search for the largest ratio
_SHARES = (0.98, 0.95, 0.9, 0.8, 0.65, 0.45, 0.25)  # -, of the level at which a violation is known


# All that Theorems 2 and 3 speak of, for one Lipschitz constant [-]: ``a_1`` and ``a_2``, least and
# greatest eigenvalue of P (V_f is |x|^2 in P_rho, so its bound needs rho a_2: another slip);
# ``sigma`` (34); ``xi`` (52); ``eta`` (44); ``contraction``, |A_K|_P; ``lipschitz``, L of (27) and
# (31); ``b``, 2 L |A_K|_P + L^2; ``tau`` (45); ``c_2`` (47); ``c_3`` (53); ``gamma`` (38);
# ``gamma_n`` (55); ``scaling``, rho; ``horizon``, N.
Quantities = dict[str, float]


def theorem2(q: Quantities) -> dict[str, Any]:
    """(29): rho sigma >= b."""
    return _condition(q["scaling"] * q["sigma"], q["b"])


def theorem3(q: Quantities) -> dict[str, Any]:
    """(41): xi + (rho - 1) sigma >= b."""
    return _condition(q["xi"] + (q["scaling"] - 1.0) * q["sigma"], q["b"])


def _condition(left: float, right: float) -> dict[str, Any]:
    """Whether left >= right, and both sides [-]."""
    return {"holds": bool(left >= right), "left": left, "right": right}


THEOREMS = {"theorem2": theorem2, "theorem3": theorem3}


def largest_lipschitz(contraction: float, allowance: float) -> float:
    """The L at which b reaches an allowance: root of L^2 + 2 L |A_K|_P = allowance.

    Args:
        contraction: |A_K|_P [-].
        allowance: Greatest b that a condition admits [-].
    """
    return float(np.sqrt(contraction**2 + allowance) - contraction)


def theorem_quantities(
    problem: StabilityProblem, ingredients: TerminalIngredients, lipschitz: float
) -> Quantities:
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
    return {
        "a_1": a_1,
        "a_2": a_2,
        "sigma": sigma,
        "xi": xi,
        "eta": eta,
        "contraction": contraction,
        "lipschitz": lipschitz,
        "b": b,
        "tau": tau,
        "c_2": c_2,
        "c_3": c_3,
        "gamma": 1.0 - a_3 / a_2,  # (38)-(39)
        "gamma_n": 1.0 - c_3 / c_2,  # (55)
        "scaling": scaling,
        "horizon": horizon,
    }


@dataclass(frozen=True)
class Violation:
    """A state on the edge of a bound.

    Attributes:
        level: x' P x there [-].
        state: x, shape (5,), error coordinates, [m, rad, m, rad, m/s].
    """

    level: float
    state: NDArray[np.float64]


def lowest_violation(
    excess: Excess, ceiling: float, rays: int = 6000, starts: int = 16
) -> Violation | None:
    """The lowest level found at which the bound fails.

    Args:
        excess: Left side minus right side.
        ceiling: Greatest level to look at [-].
        rays: Directions tried.
        starts: Local descents from the best of them.

    Returns:
        None if no ray meets a violation below the ceiling.
    """
    rays_out = directions(excess.weight, rays, np.random.default_rng(0))
    hits: NDArray[np.float64] = np.zeros((0, rays_out.shape[1]))
    for level in ceiling * np.geomspace(1e-3, 1.0, 40):
        states = np.sqrt(level) * rays_out
        values = excess(states)
        where = np.flatnonzero(values > 0.0)
        if where.size:
            hits = np.vstack([hits, states[where[np.argsort(-values[where])][:starts]]])
        if len(hits) >= starts:
            break
    found = [_descend(excess, hit) for hit in hits[:starts]]
    return min(found, key=lambda violation: violation.level, default=None)


def _descend(excess: Excess, hit: NDArray[np.float64]) -> Violation:
    """Minimise x'Px subject to excess(x) >= 0 from a violating state."""
    weight = excess.weight
    state = _minimiser(
        lambda x: (float(x @ weight @ x), 2.0 * weight @ x), hit, excess.with_gradient, 1e-13
    )
    # Step outwards until the state violates the bound indeed, not only to the solver's tolerance.
    for stretch in (1.0, 1.0 + 1e-9, 1.0 + 1e-7, 1.0 + 1e-5, 1.0 + 1e-4):
        trial = stretch * state
        level = float(trial @ weight @ trial)
        if excess(trial[None])[0] > 0.0 and level > 1e-9 * float(hit @ weight @ hit):
            return Violation(level, trial)
    return Violation(float(hit @ weight @ hit), hit)


def _minimiser(
    function: Callable[[Any], Any],
    start: NDArray[np.float64],
    bound: Callable[[Any], Any],
    tolerance: float,
) -> NDArray[np.float64]:
    """Where a function is least and a bound not below 0; both give value and gradient."""
    from scipy.optimize import minimize  # slow to load, and a controller never searches

    constraint = {"type": "ineq", "fun": lambda x: bound(x)[0], "jac": lambda x: bound(x)[1]}
    options = {"maxiter": 200, "ftol": tolerance}
    found = minimize(
        function, start, jac=True, constraints=constraint, method="SLSQP", options=options
    )
    return np.asarray(found.x)


def lipschitz_excess(
    problem: StabilityProblem, ingredients: TerminalIngredients, constant: float
) -> Excess:
    """|g(x)|_P^2 - constant^2 |x|_P^2 with g(x) = f(x, Kx) - A_K x: above 0 where (27) fails."""
    weight, linear = ingredients.weight, ingredients.closed_loop
    return Excess(problem.dynamics(), ingredients.gain, weight, constant**2 * weight, linear)


def largest_ratio(excess: Excess, level: float) -> Violation:
    """State of x'Px <= level with the largest |F(x)|_P / |x|_P.

    Args:
        excess: |F|_P^2, so made with N = 0.
        level: varrho [-].

    Returns:
        The ratio as :attr:`Violation.level`, and the state.
    """
    weight = excess.weight
    samples = directions(weight, 6000, np.random.default_rng(0))
    states = np.vstack([np.sqrt(level * part) * samples for part in (1.0, 0.7, 0.4)])
    heights = np.einsum("ki,ij,kj->k", states, weight, states)
    ratios = np.nan_to_num(excess(states) / heights, nan=-np.inf, posinf=-np.inf)

    def ratio(x: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        value, gradient = excess.with_gradient(x)
        height = float(x @ weight @ x)
        return -value / height, -gradient / height + 2.0 * value / height**2 * weight @ x

    def room(x: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        return level - float(x @ weight @ x), -2.0 * weight @ x

    best = Violation(0.0, states[0])
    for index in np.argsort(-ratios)[:ASCENTS]:
        x = _minimiser(ratio, states[index], room, 1e-14)
        x = x * min(1.0, np.sqrt(level / float(x @ weight @ x)))
        value = -ratio(x)[0]
        if np.isfinite(value) and value > best.level**2:
            best = Violation(float(np.sqrt(value)), x)
    return best


@dataclass(frozen=True)
class LevelBound:
    """How far a condition reaches.

    Attributes:
        proved: It holds on every ellipsoid up to this level [-]; 0 if none could be proved.
        violation: The lowest state that breaks it, or None if none was found.
        proof: The proof at ``proved``; where nothing was proved, the last attempt, if any.
    """

    proved: float
    violation: Violation | None
    proof: Proof | None


@dataclass(frozen=True)
class Analysis:
    """Everything that ``uav_tracking stability`` reports on a configuration.

    Attributes:
        problem: The configuration.
        ingredients: K, P, P_rho.
        quantities: Theorems 2 and 3 with the proved Lipschitz constant at the terminal level.
        lipschitz: L(varrho) of (31), a true maximum, from both sides: ``level``, varrho [-];
            ``lower``, attained at ``state`` [-]; ``upper``, proved [-], infinite if nothing was.
        reaches: How far (29) of ``theorem2``, (41) of ``theorem3`` and the ``decrease`` itself
            reach, whatever U is.
        inputs: The input limit that binds first.
        domain: The domain limit that binds first.
        direct: The direct condition at the terminal level, None where no level is possible.
        refuted: The known counterexample to the decrease is confirmed in intervals.
    """

    problem: StabilityProblem
    ingredients: TerminalIngredients
    quantities: Quantities
    lipschitz: dict[str, Any]
    reaches: dict[str, LevelBound]
    inputs: Limit
    domain: Limit
    direct: DirectCondition | None
    refuted: bool

    @property
    def level(self) -> float:
        """The certified varrho, 0 if there is none."""
        return self.direct.level if self.direct is not None and self.direct.holds else 0.0

    @property
    def certified(self) -> bool:
        """Whether there is a proved terminal set."""
        return self.level > 0.0

    @property
    def binding(self) -> str:
        """Which limit is in the way of a larger terminal set, in words."""
        reach = self.reaches["decrease"]
        if self.direct is None:
            return obstacle(self.inputs, self.domain, reach.proof)
        levels = {
            f"U: {self.inputs.name}": self.inputs.level,
            f"the model's domain: {self.domain.name}": self.domain.level,
            "the decrease of V_f": reach.proved,
        }
        return min(levels, key=lambda name: levels[name])


def obstacle(inputs: Limit, domain: Limit, decrease: Proof | None = None) -> str:
    """Why not even a small ellipsoid is a terminal set.

    Args:
        inputs: The input limit that binds first.
        domain: The domain limit that binds first.
        decrease: The last attempt to prove the decrease, if there was one.
    """
    if inputs.level <= 0.0:
        return f"{inputs.name}: the steady input of the orbit is outside it"
    if domain.level <= 0.0:
        return f"{domain.name}: not even at the orbit"
    stuck = None if decrease is None else decrease.stuck
    return "the decrease of V_f" + ("" if stuck is None else f": {stuck}")


def analyse(problem: StabilityProblem, say: Say = lambda _: None, boxes: int = BOXES) -> Analysis:
    """Carry out Section 5.

    Args:
        problem: The configuration.
        say: Told in words what is being done.
        boxes: Budget of each single proof.
    """
    parts = problem, problem.ingredients()
    inputs, domain = limits(*parts)
    ceiling = 0.9999 * domain.level
    say("decrease of V_f: how far it reaches")
    reach = _reach(partial(decrease, *parts), decrease_excess(*parts), ceiling, boxes)
    broken = reach.violation
    refuted = broken is not None and decrease(*parts, broken.level * (1.0 + 1e-9)).violated_at(
        broken.state
    )

    direct = None
    top = min(allowed_level(inputs, domain), reach.proved)
    if top > 0.0:
        say(f"direct condition: proving at level {top:.4g}")
        for share in (1.0, *_SHARES[2:]):
            direct = prove_direct_condition(*parts, share * top, boxes)
            if direct.holds:
                break

    # The level at which L is wanted: the terminal set's, or whatever U would allow.
    level = direct.level if direct is not None else max(min(inputs.level, ceiling), 0.1)
    say(f"Lipschitz constant at level {level:.4g}")
    best = largest_ratio(lipschitz_excess(*parts, 0.0), level)
    constants = [factor * best.level for factor in (1.01, 1.03, 1.05, 1.15, 1.5, 2.0)]
    upper, _ = _first_proved(constants, lambda each: lipschitz_bound(*parts, each, level), boxes)
    lipschitz = {
        "level": level,
        "lower": best.level,
        "upper": float("inf") if upper is None else upper,
        "state": best.state.tolist(),
    }
    quantities = theorem_quantities(*parts, lipschitz["upper"])
    reaches = {}
    for name, theorem in THEOREMS.items():
        say(f"{name}: how far its condition reaches")
        constant = largest_lipschitz(quantities["contraction"], theorem(quantities)["left"])
        reaches[name] = _reach(
            partial(lipschitz_bound, *parts, constant),
            lipschitz_excess(*parts, constant),
            ceiling if constant > 0.0 else 0.0,
            boxes,
        )
    reaches["decrease"] = reach
    return Analysis(*parts, quantities, lipschitz, reaches, inputs, domain, direct, refuted)


def _reach(
    bound: Callable[[float], QuadraticBound], excess: Excess, ceiling: float, boxes: int
) -> LevelBound:
    """Prove a bound as near to its lowest violation as the budget allows."""
    found = lowest_violation(excess, ceiling) if ceiling > 0.0 else None
    limit = ceiling if found is None else min(found.level, ceiling)
    levels = [share * limit for share in _SHARES] if limit > 0.0 else []
    proved, proof = _first_proved(levels, bound, boxes)
    return LevelBound(proved or 0.0, found, proof)


def _first_proved(
    numbers: list[float], bound: Callable[[float], QuadraticBound], boxes: int
) -> tuple[float | None, Proof | None]:
    """The first of some numbers whose bound is proved within twice a budget; the last attempt."""
    proof, left = None, 2 * boxes
    for number in numbers:
        proof = prove(bound(number), min(boxes, left))
        if proof.proved:
            return number, proof
        left -= proof.statistics["boxes"]
        if left <= 0:
            break
    return None, proof
