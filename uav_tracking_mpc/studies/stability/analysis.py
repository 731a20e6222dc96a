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

Four levels varrho of the ellipsoid x'P_rho x <= varrho come out of it: up to which Theorem 3 can be
applied, up to which the decrease itself is proved, up to which U allows, and the certified one, at
which the direct condition holds in all its parts. Every level is proved at the value that is
reported; the smallest level at which a counterexample is known is reported beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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
from uav_tracking_mpc.studies.stability.theorems import (
    TheoremQuantities,
    Violation,
    largest_lipschitz,
    largest_ratio,
    lipschitz_excess,
    lowest_violation,
    theorem_quantities,
)
from uav_tracking_mpc.terminal.ingredients import (
    StabilityProblem,
    TerminalIngredients,
    decrease_excess,
)
from uav_tracking_mpc.terminal.quadratic_bound import QuadraticBound

Say = Callable[[str], None]
_SHARES = (0.98, 0.95, 0.9, 0.8, 0.65, 0.45, 0.25)  # -, of the level at which a violation is known


@dataclass(frozen=True)
class LevelBound:
    """How far a condition reaches.

    Attributes:
        proved: It holds on every ellipsoid up to this level [-]; 0 if none could be proved.
        violation: The lowest level [-] at which a state breaks it, or None if none was found.
        state: That state in error coordinates, [m, rad, m, rad, m/s].
        proof: The proof at ``proved``; where nothing was proved, the last attempt, if any.
    """

    proved: float
    violation: float | None
    state: tuple[float, ...] | None
    proof: Proof | None


@dataclass(frozen=True)
class LipschitzBound:
    """L(varrho) of (31), a true maximum, from both sides.

    Attributes:
        level: varrho [-].
        lower: Attained at ``state`` [-].
        upper: Proved [-]; infinite if nothing was.
        state: Where ``lower`` is attained, error coordinates, [m, rad, m, rad, m/s].
    """

    level: float
    lower: float
    upper: float
    state: tuple[float, ...]


@dataclass(frozen=True)
class Analysis:
    """Everything that ``uav_tracking stability`` reports on a configuration.

    Attributes:
        problem: The configuration.
        ingredients: K, P, P_rho.
        quantities: Theorems 2 and 3 with the proved Lipschitz constant at the terminal level.
        lipschitz: L at the terminal level.
        theorem2: How far (29) reaches.
        theorem3: How far (41) reaches.
        decrease: How far the decrease itself reaches, whatever U is.
        inputs: The input limit that binds first.
        domain: The domain limit that binds first.
        direct: The direct condition at the terminal level, None where no level is possible.
        refuted: The known counterexample to the decrease is confirmed in intervals.
    """

    problem: StabilityProblem
    ingredients: TerminalIngredients
    quantities: TheoremQuantities
    lipschitz: LipschitzBound
    theorem2: LevelBound
    theorem3: LevelBound
    decrease: LevelBound
    inputs: Limit
    domain: Limit
    direct: DirectCondition | None
    refuted: bool

    @property
    def certified(self) -> bool:
        """Whether there is a proved terminal set."""
        return self.direct is not None and self.direct.holds

    @property
    def level(self) -> float:
        """The certified varrho, 0 if there is none."""
        return self.direct.level if self.direct is not None and self.direct.holds else 0.0

    @property
    def binding(self) -> str:
        """Which limit is in the way of a larger terminal set, in words."""
        if self.direct is None:
            return obstacle(self.inputs, self.domain, self.decrease.proof)
        levels = {
            f"U: {self.inputs.name}": self.inputs.level,
            f"the model's domain: {self.domain.name}": self.domain.level,
            "the decrease of V_f": self.decrease.proved,
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
    return "the decrease of V_f" + ("" if stuck is None else f": {stuck.reason}")


def analyse(problem: StabilityProblem, say: Say | None = None, boxes: int = BOXES) -> Analysis:
    """Carry out Section 5.

    Args:
        problem: The configuration.
        say: Told in words what is being done.
        boxes: Budget of each single proof.
    """
    say = say or (lambda text: None)
    ingredients = problem.ingredients()
    inputs, domain = limits(problem, ingredients)

    say("decrease of V_f: searching for violations")
    ceiling = 0.9999 * domain.level
    excess = decrease_excess(problem, ingredients)
    found = lowest_violation(excess, ceiling) if ceiling > 0.0 else None
    say("decrease of V_f: proving")
    reach = _reach(lambda level: decrease(problem, ingredients, level), found, ceiling, boxes)
    refuted = found is not None and decrease(
        problem, ingredients, found.level * (1.0 + 1e-9)
    ).violated_at(found.state)

    direct = None
    top = min(allowed_level(inputs, domain), reach.proved)
    if top > 0.0:
        say(f"direct condition: proving at level {top:.4g}")
        for share in (1.0, *_SHARES[2:]):
            direct = prove_direct_condition(problem, ingredients, share * top, boxes)
            if direct.holds:
                break

    # The level at which L is wanted: the terminal set's, or whatever U would allow.
    level = direct.level if direct is not None else max(min(inputs.level, ceiling), 0.1)
    say(f"Lipschitz constant at level {level:.4g}")
    lipschitz = lipschitz_constant(problem, ingredients, level, boxes)
    quantities = theorem_quantities(problem, ingredients, lipschitz.upper)
    theorems = []
    for name, allowance in (("2", quantities.theorem2.left), ("3", quantities.theorem3.left)):
        say(f"Theorem {name}: how far its condition reaches")
        constant = largest_lipschitz(quantities.contraction, allowance)
        theorems.append(lipschitz_reach(problem, ingredients, constant, ceiling, boxes))
    return Analysis(
        problem=problem,
        ingredients=ingredients,
        quantities=quantities,
        lipschitz=lipschitz,
        theorem2=theorems[0],
        theorem3=theorems[1],
        decrease=reach,
        inputs=inputs,
        domain=domain,
        direct=direct,
        refuted=refuted,
    )


def lipschitz_constant(
    problem: StabilityProblem, ingredients: TerminalIngredients, level: float, boxes: int = BOXES
) -> LipschitzBound:
    """L(varrho) of (31): a maximum found from below, and a bound proved from above.

    Args:
        problem: The configuration.
        ingredients: A_K and P_rho.
        level: varrho [-].
        boxes: Budget of each proof.
    """
    best = largest_ratio(lipschitz_excess(problem, ingredients, 0.0), level)
    constants = [factor * best.level for factor in (1.01, 1.03, 1.05, 1.15, 1.5, 2.0)]
    upper, _ = _first_proved(
        constants, lambda constant: lipschitz_bound(problem, ingredients, constant, level), boxes
    )
    found = float("inf") if upper is None else upper
    return LipschitzBound(level, best.level, found, tuple(best.state.tolist()))


def lipschitz_reach(
    problem: StabilityProblem,
    ingredients: TerminalIngredients,
    constant: float,
    ceiling: float,
    boxes: int = BOXES,
) -> LevelBound:
    """The largest varrho with L(varrho) <= constant, proved and refuted.

    Args:
        problem: The configuration.
        ingredients: A_K and P_rho.
        constant: What (29) or (41) leaves for L [-].
        ceiling: Levels above [-] are not looked at.
        boxes: Budget of each proof.
    """
    ceiling = ceiling if constant > 0.0 else 0.0
    excess = lipschitz_excess(problem, ingredients, constant)
    found = lowest_violation(excess, ceiling) if ceiling > 0.0 else None
    return _reach(
        lambda level: lipschitz_bound(problem, ingredients, constant, level), found, ceiling, boxes
    )


def _reach(
    bound: Callable[[float], QuadraticBound], found: Violation | None, ceiling: float, boxes: int
) -> LevelBound:
    """Prove a bound as near to its known violation as the budget allows."""
    limit = ceiling if found is None else min(found.level, ceiling)
    violation = None if found is None else found.level
    state = None if found is None else tuple(found.state.tolist())
    levels = [share * limit for share in _SHARES] if limit > 0.0 else []
    proved, proof = _first_proved(levels, bound, boxes)
    return LevelBound(proved or 0.0, violation, state, proof)


def _first_proved(
    numbers: list[float], bound: Callable[[float], QuadraticBound], boxes: int
) -> tuple[float | None, Proof | None]:
    """The first of some numbers whose bound is proved within twice a budget; the last attempt."""
    proof, left = None, 2 * boxes
    for number in numbers:
        proof = prove(bound(number), min(boxes, left))
        if proof.proved:
            return number, proof
        left -= proof.boxes
        if left <= 0:
            break
    return None, proof
