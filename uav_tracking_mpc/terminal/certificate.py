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

"""The certificate: a proof written down, so that others can check it and a controller can cite it.

It holds the model, every parameter, P, K, varrho, the tree of boxes with the multiplier of each
leaf, how much work it was, and the versions of the libraries that did it; a digest covers it all.
Whether it is true is for ``verify`` to say, which knows nothing of how it was found. Whether it
speaks of the configuration that is flown is for :func:`certificate_status`.
"""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from uav_tracking_mpc.terminal.direct_condition import SLACK, DirectCondition
from uav_tracking_mpc.terminal.ingredients import TerminalIngredients
from uav_tracking_mpc.terminal.stability_problem import StabilityProblem

FORMAT = "uav_tracking_mpc terminal set certificate 1"
TOLERANCE = 1e-11  # relative, of P and K recomputed elsewhere: far below the proof's slack


def problem_parameters(problem: StabilityProblem) -> dict[str, Any]:
    """Everything that the terminal set of a ``problem`` depends on, as JSON values, so not N."""
    return {
        "model": problem.model,
        "scheme": problem.scheme,
        "step_s": float(problem.step),
        "orbit": asdict(problem.orbit),
        "state_weight": np.asarray(problem.state_weight, dtype=float).tolist(),
        "input_weight": np.asarray(problem.input_weight, dtype=float).tolist(),
        "scaling": float(problem.scaling),
        "input_lower": np.asarray(problem.input_lower, dtype=float).tolist(),
        "input_upper": np.asarray(problem.input_upper, dtype=float).tolist(),
    }


def certificate(
    problem: StabilityProblem, ingredients: TerminalIngredients, proved: DirectCondition
) -> dict[str, Any]:
    """Write a proved direct condition down.

    Args:
        problem: The configuration.
        ingredients: Its K and P_rho.
        proved: What was proved of them.

    Raises:
        ValueError: It is not proved.
    """
    if not proved.holds:
        raise ValueError(f"no certificate at level {proved.level:.6g}: {proved.reason}")
    proof = proved.decrease
    content: dict[str, Any] = {
        "format": FORMAT,
        "problem": problem_parameters(problem),
        "gain": ingredients.gain.tolist(),
        "weight": ingredients.weight.tolist(),
        "level": float(proved.level),
        "slack": SLACK,
        "root": list(proof.half),
        "tree": proof.tree,
        "multipliers": list(proof.multipliers),
        "statistics": {"boxes": proof.boxes, "leaves": proof.leaves, "depth": proof.depth},
        "versions": _versions(),
    }
    content["digest"] = digest(content)
    return content


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in ("uav_tracking_mpc", "python-flint", "casadi", "numpy", "scipy"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed as a package"
    return found


def digest(content: dict[str, Any]) -> str:
    """SHA-256 of the ``content`` without its digest, in one canonical spelling of JSON."""
    rest = {key: value for key, value in content.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def read_certificate(path: Path) -> dict[str, Any]:
    """Read a certificate without checking it.

    Args:
        path: The file.

    Raises:
        ValueError: The file holds no JSON object.
    """
    content = json.loads(path.read_text())
    if not isinstance(content, dict):
        raise ValueError(f"{path} holds no JSON object, so no certificate")
    return content


def mismatch(
    content: dict[str, Any],
    problem: StabilityProblem,
    ingredients: TerminalIngredients,
    level: float,
) -> str | None:
    """Why a certificate says nothing about a configuration, or None if it does cover it.

    Args:
        content: The certificate.
        problem: What is flown.
        ingredients: K and P_rho that are flown.
        level: varrho that is flown [-].
    """
    try:
        if content["format"] != FORMAT:
            return f"format is {content['format']!r}, must be {FORMAT!r}"
        if content["digest"] != digest(content):
            return "digest does not match the content: the file was changed"
        flown, proved = problem_parameters(problem), content["problem"]
        for key, value in flown.items():
            if proved[key] != value:
                return f"{key} is {value} in flight, {proved[key]} in the certificate"
        for name, matrix in (("gain", ingredients.gain), ("weight", ingredients.weight)):
            stored = np.array(content[name], dtype=float)
            if stored.shape != matrix.shape or not np.allclose(
                stored, matrix, rtol=TOLERANCE, atol=TOLERANCE * float(np.abs(matrix).max())
            ):
                return f"{name} in flight differs from the certificate's"
        if not 0.0 < level <= content["level"]:
            return f"level in flight is {level:.6g}, proved up to {content['level']:.6g}"
    except (KeyError, TypeError, ValueError) as error:
        return f"malformed certificate: {error!r}"
    return None
