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

from dataclasses import replace
from typing import Any

import numpy as np

from uav_tracking_mpc.report.pages import Table
from uav_tracking_mpc.studies.stability.analysis import Say, lowest_violation, obstacle
from uav_tracking_mpc.studies.stability.proof import (
    BOXES,
    allowed_level,
    limits,
    prove_direct_condition,
)
from uav_tracking_mpc.studies.stability.stability_campaign import local_flights
from uav_tracking_mpc.studies.study import Study
from uav_tracking_mpc.terminal.ingredients import StabilityProblem, decrease_excess, directions

SCALINGS = (1.5, 2.5, 4.0, 8.0)  # -, times P
INPUT_FACTORS = (0.3, 1.0, 3.0, 10.0, 30.0)  # -, times R

# One choice of weights: ``scaling``, rho; ``input_factor``, R over the R asked for; ``level``, the
# varrho that U, the domain and the search for violations allow; ``volume`` of X_f and ``cost``, of
# kappa_l in closed loop from common states, both relative to the choice asked for; ``extents``,
# half-widths of X_f in [m, rad, m, rad, m/s]; ``binding``, the limit that is in the way of a larger
# set; ``proved``, whether the direct condition was, None where it was not tried.
Candidate = dict[str, Any]


def design(
    problem: StabilityProblem,
    say: Say = lambda _: None,
    scalings: tuple[float, ...] = SCALINGS,
    input_factors: tuple[float, ...] = INPUT_FACTORS,
    boxes: int = BOXES,
) -> Study:
    """Search rho and the scale of R against Q.

    Args:
        problem: What is asked for.
        say: Told what is being done.
        scalings: Values of rho [-].
        input_factors: Factors of R [-].
        boxes: Budget of each proof.

    Returns:
        Its content: the candidate that is ``asked``; all ``candidates``, largest volume first; the
        ``best``, the largest proved one, or None; ``words``.
    """
    choices = [
        (problem.scaling, 1.0),
        *((scaling, factor) for factor in input_factors for scaling in scalings),
    ]
    raw = []
    for choice in dict.fromkeys(choices):
        say("rho = {:g}, R times {:g}".format(*choice))
        raw.append(_candidate(problem, *choice))
    volume, cost = raw[0]["volume"] or 1.0, raw[0]["cost"]
    for each in raw:
        each |= {"volume": each["volume"] / volume, "cost": each["cost"] / cost}
    asked, ranked, best = {**raw[0]}, sorted(raw, key=lambda each: -each["volume"]), None
    for each in ranked:
        if each["volume"] <= 0.0:
            break
        say("proving rho = {scaling:g}, R times {input_factor:g}".format_map(each))
        changed = changed_problem(problem, each["scaling"], each["input_factor"])
        outcome = prove_direct_condition(changed, changed.ingredients(), each["level"], boxes)
        say(outcome.reason)
        each["proved"] = outcome.holds
        if outcome.holds:
            best = each
            break
    words = _words(problem, asked, best)
    content = {"asked": asked, "candidates": ranked, "best": best, "words": words}
    return Study("design", content, [words, _table(ranked)], good=best is not None)


def changed_problem(
    problem: StabilityProblem, scaling: float, input_factor: float
) -> StabilityProblem:
    """The configuration with another rho [-] and R scaled by a factor [-]."""
    return replace(problem, scaling=scaling, input_weight=input_factor * problem.input_weight)


def _candidate(asked: StabilityProblem, scaling: float, input_factor: float) -> Candidate:
    changed = changed_problem(asked, scaling, input_factor)
    parts = changed.ingredients()
    inputs, domain = limits(changed, parts)
    level = allowed_level(inputs, domain)
    binding = (inputs if inputs.level <= domain.level else domain).name
    if level <= 0.0:
        level, binding = 0.0, obstacle(inputs, domain)
    else:
        found = lowest_violation(decrease_excess(changed, parts), level, rays=3000, starts=6)
        if found is not None and found.level < level:
            level, binding = 0.97 * found.level, "the decrease of V_f"
    return {
        "scaling": scaling,
        "input_factor": input_factor,
        "level": level,
        "volume": float(np.sqrt(level**5 / np.linalg.det(parts.weight))),
        "extents": np.sqrt(level * np.diag(np.linalg.inv(parts.weight))).tolist(),
        "cost": _cost(asked, parts.gain),
        "binding": binding,
        "proved": None,
    }


def _cost(asked: StabilityProblem, gain: np.ndarray, steps: int = 120) -> float:
    """Mean cost of kappa_l in the weights asked for, from states common to all candidates."""
    weight, total = asked.ingredients().weight, 0.0
    states = np.sqrt(0.5) * directions(weight, 200, np.random.default_rng(0))
    for x in local_flights(asked, gain, states, steps - 1):
        u = x @ gain.T
        total += float(np.einsum("ki,ij,kj->", x, asked.state_weight, x))
        total += float(np.einsum("ki,ij,kj->", u, asked.input_weight, u))
    return total / len(states) if np.isfinite(total) else float("inf")


def _table(candidates: list[Candidate]) -> Table:
    proved = {True: "yes", False: "no", None: "-"}
    rows = [
        [
            f"{each['scaling']:g}",
            f"{each['input_factor']:g}",
            f"{each['level']:.4g}",
            f"{each['volume']:.3g}",
            f"{each['cost']:.3f}",
            proved[each["proved"]],
            each["binding"],
        ]
        for each in candidates
    ]
    headings = ("rho", "R times", "varrho", "volume", "cost", "proved", "limited by")
    return Table(headings, rows, numeric=headings[:5])


def _words(problem: StabilityProblem, asked: Candidate, best: Candidate | None) -> str:
    orbit = problem.orbit
    name = f"orbit r = {orbit.range:g} m, z = {orbit.altitude:g} m, v = {orbit.speed:g} m/s"
    if best is None:
        return (
            f"{name}: no choice of rho and R tried has a certified region. In the way: "
            f"{asked['binding']}."
        )
    units = ("m", "rad", "m", "rad", "m/s")
    pairs = zip(best["extents"], units, strict=True)
    spans = ", ".join(f"{value:.3g} {unit}" for value, unit in pairs)
    return (
        f"{name}: as asked, varrho = {asked['level']:.4g}, limited by {asked['binding']}. Largest "
        f"proved: rho = {best['scaling']:g}, R times {best['input_factor']:g}, "
        f"varrho = {best['level']:.4g}, {best['volume']:.3g} times the volume, half-widths "
        f"{spans}, limited by {best['binding']}; closed-loop cost {best['cost']:.3f} times that "
        "of the choice asked for."
    )
