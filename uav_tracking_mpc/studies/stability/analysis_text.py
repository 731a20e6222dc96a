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

"""An analysis for people and for programs: JSON with fixed keys, and plain words."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from uav_tracking_mpc.studies.stability.analysis import Analysis, LevelBound
from uav_tracking_mpc.terminal.certificate import problem_parameters


def as_json(analysis: Analysis) -> dict[str, Any]:
    """The analysis as JSON values; infinities and nan become null.

    Keys that programs may rely on: ``conditions.theorem2``, ``conditions.theorem3`` ({holds, left,
    right}, with the proved L at the terminal level), ``varrho.{theorem3, decrease, inputs,
    certified}`` (all proved), ``lipschitz.{upper, lower}``, ``certified``.

    Args:
        analysis: Of a configuration.
    """
    quantities, direct = analysis.quantities, analysis.direct
    content = {
        "config": analysis.problem.name,
        "problem": problem_parameters(analysis.problem),
        "horizon": analysis.problem.horizon,
        "certified": analysis.certified,
        "conditions": {
            "level": analysis.lipschitz.level,
            "theorem2": quantities.theorem2.as_dict(),
            "theorem3": quantities.theorem3.as_dict(),
        },
        "varrho": {
            "theorem2": analysis.theorem2.proved,
            "theorem3": analysis.theorem3.proved,
            "decrease": analysis.decrease.proved,
            "inputs": analysis.inputs.level,
            "domain": analysis.domain.level,
            "certified": analysis.level,
        },
        "violated_at": {
            "theorem2": analysis.theorem2.violation,
            "theorem3": analysis.theorem3.violation,
            "decrease": analysis.decrease.violation,
            "decrease_state": analysis.decrease.state,
            "decrease_confirmed": analysis.refuted,
        },
        "binding": analysis.binding,
        "lipschitz": asdict(analysis.lipschitz),
        "quantities": asdict(quantities),
        "gain": analysis.ingredients.gain.tolist(),
        "weight": analysis.ingredients.weight.tolist(),
        "proofs": {
            name: _proof(bound)
            for name, bound in (
                ("theorem2", analysis.theorem2),
                ("theorem3", analysis.theorem3),
                ("decrease", analysis.decrease),
            )
        },
        "verdict": "no terminal set" if direct is None else direct.reason,
    }
    return _finite(content)


def _proof(bound: LevelBound) -> dict[str, Any] | None:
    if bound.proof is None:
        return None
    proof = bound.proof
    return {
        "boxes": proof.boxes,
        "leaves": proof.leaves,
        "depth": proof.depth,
        "stopped": None if proof.stuck is None else proof.stuck.reason,
    }


def _finite(value: Any) -> Any:
    """JSON knows no infinity."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value


def as_words(analysis: Analysis) -> str:
    """What was found, in a few lines.

    Args:
        analysis: Of a configuration.
    """
    problem, orbit = analysis.problem, analysis.problem.orbit
    lines = [
        f"{problem.name}: {problem.model} model, {problem.scheme}, T_s = {problem.step:g} s, "
        f"orbit r = {orbit.range:g} m, z = {orbit.altitude:g} m, v = {orbit.speed:g} m/s",
        f"  L(varrho = {analysis.lipschitz.level:.4g}) between {analysis.lipschitz.lower:.4f} "
        f"(attained) and {analysis.lipschitz.upper:.4f} "
        f"({'proved' if math.isfinite(analysis.lipschitz.upper) else 'not proved: see --boxes'})",
    ]
    for number, condition in ((2, analysis.quantities.theorem2), (3, analysis.quantities.theorem3)):
        holds = "holds" if condition.holds else "does not hold"
        lines.append(
            f"  Theorem {number} there: {condition.left:.4f} against {condition.right:.4f}: {holds}"
        )
    lines += [
        _reach("(29) of Theorem 2", analysis.theorem2),
        _reach("(41) of Theorem 3", analysis.theorem3),
        _reach("the decrease itself", analysis.decrease),
        f"  U allows varrho = {analysis.inputs.level:.4g} ({analysis.inputs.name})",
    ]
    if analysis.certified:
        lines.append(
            f"  CERTIFIED: x'P_rho x <= {analysis.level:.6g} is a terminal set; "
            f"larger is prevented by {analysis.binding}"
        )
    else:
        lines.append(f"  NOT CERTIFIED: in the way is {analysis.binding}")
        if analysis.direct is not None:
            lines.append(f"  {analysis.direct.reason}")
    return "\n".join(lines)


def _reach(name: str, bound: LevelBound) -> str:
    known = (
        "no violation known" if bound.violation is None else f"violated at {bound.violation:.4g}"
    )
    words = f"  {name}: proved up to varrho = {bound.proved:.4g}, {known}"
    if bound.proof is None or bound.proof.stuck is None:
        return words
    return f"{words}; not proved beyond: {bound.proof.stuck.reason}"
