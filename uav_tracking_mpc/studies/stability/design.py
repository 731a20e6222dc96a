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

"""Design help: rho and scalings of Q and R for the largest certified region.

X_f grows in a norm that itself changes with rho, Q and R, so regions are compared by volume: that
of x'P_rho x <= varrho is proportional to sqrt(varrho^5 / det P_rho). Only the ratio of Q to R
matters to K, and rho only to the decrease; both move varrho as far as U allows. Against it stands
the cost of flying: the same flights, scored with the weights that were asked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.stability.analysis import obstacle
from uav_tracking_mpc.studies.stability.proof import (
    BOXES,
    allowed_level,
    limits,
    prove_direct_condition,
)
from uav_tracking_mpc.studies.stability.theorems import lowest_violation
from uav_tracking_mpc.terminal.ingredients import StabilityProblem, decrease_excess, directions

SCALINGS = (1.5, 2.5, 4.0, 8.0)  # -, times P
INPUT_FACTORS = (0.3, 1.0, 3.0, 10.0, 30.0)  # -, times R


@dataclass(frozen=True)
class Candidate:
    """One choice of weights.

    Attributes:
        scaling: rho [-].
        input_factor: R is this times the R asked for [-].
        level: varrho [-] that U, the domain and the search for violations allow.
        volume: Of X_f, relative to the choice asked for [-].
        extents: Half-widths of X_f along the five states, in [m, rad, m, rad, m/s].
        cost: Closed-loop cost of kappa_l from common states, relative to the choice asked for [-].
        binding: Which limit is in the way of a larger set.
        proved: The direct condition was proved at ``level``; None if it was not tried.
    """

    scaling: float
    input_factor: float
    level: float
    volume: float
    extents: tuple[float, ...]
    cost: float
    binding: str
    proved: bool | None = None


@dataclass(frozen=True)
class Design:
    """Outcome of a search.

    Attributes:
        asked: The configuration as it was asked for.
        candidates: All choices, largest volume first.
        best: The largest proved one, or None.
        words: What to know, in plain words.
    """

    asked: Candidate
    candidates: tuple[Candidate, ...]
    best: Candidate | None
    words: str


def design(
    problem: StabilityProblem,
    say: Callable[[str], None] | None = None,
    scalings: tuple[float, ...] = SCALINGS,
    input_factors: tuple[float, ...] = INPUT_FACTORS,
    boxes: int = BOXES,
) -> Design:
    """Search rho and the scale of R against Q.

    Args:
        problem: What is asked for.
        say: Told what is being done.
        scalings: Values of rho [-].
        input_factors: Factors of R [-].
        boxes: Budget of each proof.
    """
    say = say or (lambda text: None)
    raw = [_candidate(problem, problem.scaling, 1.0, problem)]
    for factor in input_factors:
        say(f"R times {factor:g}")
        for scaling in scalings:
            if (scaling, factor) != (problem.scaling, 1.0):
                raw.append(_candidate(problem, scaling, factor, problem))
    base = raw[0]
    volume, cost = base.volume or 1.0, base.cost
    relative = [replace(c, volume=c.volume / volume, cost=c.cost / cost) for c in raw]
    ranked = sorted(relative, key=lambda c: -c.volume)
    best = None
    for index, candidate in enumerate(ranked):
        if candidate.volume <= 0.0:
            break
        say(f"proving rho = {candidate.scaling:g}, R times {candidate.input_factor:g}")
        changed = changed_problem(problem, candidate.scaling, candidate.input_factor)
        outcome = prove_direct_condition(changed, changed.ingredients(), candidate.level, boxes)
        say(outcome.reason)
        ranked[index] = replace(candidate, proved=outcome.holds)
        if outcome.holds:
            best = ranked[index]
            break
    return Design(relative[0], tuple(ranked), best, _words(problem, relative[0], best))


def changed_problem(
    problem: StabilityProblem, scaling: float, input_factor: float
) -> StabilityProblem:
    """The configuration with another rho and R scaled.

    Args:
        problem: The configuration.
        scaling: The other rho [-].
        input_factor: R is this times its R [-].
    """
    return replace(problem, scaling=scaling, input_weight=input_factor * problem.input_weight)


def _candidate(
    problem: StabilityProblem, scaling: float, input_factor: float, asked: StabilityProblem
) -> Candidate:
    changed = changed_problem(problem, scaling, input_factor)
    parts = changed.ingredients()
    weight = parts.weight
    inputs, domain = limits(changed, parts)
    ceiling = allowed_level(inputs, domain)
    cost = _cost(asked, parts.gain)
    nothing = (0.0,) * 5
    if ceiling <= 0.0:
        words = obstacle(inputs, domain)
        return Candidate(scaling, input_factor, 0.0, 0.0, nothing, cost, words)
    found = lowest_violation(decrease_excess(changed, parts), ceiling, rays=3000, starts=6)
    level, binding = ceiling, (inputs if inputs.level <= domain.level else domain).name
    if found is not None and found.level < ceiling:
        level, binding = 0.97 * found.level, "the decrease of V_f"
    inverse = np.linalg.inv(weight)
    volume = float(np.sqrt(level**5 / np.linalg.det(weight)))
    extents = tuple(np.sqrt(level * np.diag(inverse)).tolist())
    return Candidate(scaling, input_factor, level, volume, extents, cost, binding)


def _cost(asked: StabilityProblem, gain: np.ndarray, steps: int = 120) -> float:
    """Mean cost of kappa_l in the weights asked for, from states common to all candidates."""
    dynamics, parts = asked.dynamics(), asked.ingredients()
    states = np.sqrt(0.5) * directions(parts.weight, 200, np.random.default_rng(0))
    total = 0.0
    for _ in range(steps):
        u = states @ gain.T
        total += float(np.einsum("ki,ij,kj->", states, asked.state_weight, states))
        total += float(np.einsum("ki,ij,kj->", u, asked.input_weight, u))
        states = np.array(dynamics(states.T, u.T)).T
    return total / len(states) if np.isfinite(total) else float("inf")


def candidate_table(found: Design) -> Table:
    """All candidates.

    Args:
        found: Outcome of a search.
    """
    proved = {True: "yes", False: "no", None: "-"}
    rows = [
        (
            f"{c.scaling:g}",
            f"{c.input_factor:g}",
            f"{c.level:.4g}",
            f"{c.volume:.3g}",
            f"{c.cost:.3f}",
            proved[c.proved],
            c.binding,
        )
        for c in found.candidates
    ]
    headings = ("rho", "R times", "varrho", "volume", "cost", "proved", "limited by")
    return Table(headings, rows, numeric=headings[:5])


def _words(problem: StabilityProblem, asked: Candidate, best: Candidate | None) -> str:
    orbit = problem.orbit
    name = f"orbit r = {orbit.range:g} m, z = {orbit.altitude:g} m, v = {orbit.speed:g} m/s"
    if best is None:
        return (
            f"{name}: no choice of rho and R tried has a certified region. In the way: "
            f"{asked.binding}."
        )
    spans = ", ".join(
        f"{value:.3g} {unit}"
        for value, unit in zip(best.extents, ("m", "rad", "m", "rad", "m/s"), strict=True)
    )
    return (
        f"{name}: as asked, varrho = {asked.level:.4g}, limited by {asked.binding}. "
        f"Largest proved: rho = {best.scaling:g}, "
        f"R times {best.input_factor:g}, "
        f"varrho = {best.level:.4g}, "
        f"{best.volume:.3g} times the volume, half-widths {spans}, limited by {best.binding}; "
        f"closed-loop cost {best.cost:.3f} times that of the choice asked for."
    )
