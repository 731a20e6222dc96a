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

"""The certificate: a proof written down, and its checker.

It holds the model, every parameter, P, K, varrho, the tree of boxes with the multiplier of each
leaf, how much work it was, and the versions of the libraries that did it; a digest covers it all.
Whether it speaks of the configuration that is flown is for :func:`mismatch`, whether it is true for
:func:`verify`, which checks it from scratch and knows nothing of how the proof was found.

The checker trusts ``dynamics`` (the models, one step of them), CasADi's derivatives of them, and
intervals of doubles. The search for a proof uses the same test of boxes, but nothing that it found
is believed: not the tree, not the multipliers, not that they were confirmed. A model must be
installed: no file that a certificate names is run. In order it checks that

1. the content is complete, its digest right, P, Q and R positive definite, rho at least 1, and the
   orbit steady by the structure of the model;
2. the root box holds the ellipsoid, and the tree of halved boxes is complete: its leaves cover it;
3. inputs stay in U and states in the model's domain on the ellipsoid, with a margin that covers P
   and K recomputed elsewhere;
4. on every leaf V_f(f(x, Kx)) - V_f(x) + L(x, Kx) <= -slack V_f(x) within the ellipsoid
   (``quadratic_bound``).
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import NU, NX
from uav_tracking_mpc.dynamics.relative_models import RELATIVE_MODEL
from uav_tracking_mpc.terminal.ingredients import StabilityProblem, TerminalIngredients
from uav_tracking_mpc.terminal.interval import Interval, definite, exact, inverse_of, reach
from uav_tracking_mpc.terminal.quadratic_bound import (
    ClosedLoop,
    QuadraticBound,
    decrease_bound,
    stage_weight,
)

FORMAT = "uav_tracking_mpc terminal set certificate 1"
TOLERANCE = 1e-11  # -, relative, of P and K recomputed elsewhere: far below the proof's slack


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
    try:
        content = json.loads(path.read_text())
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{path} holds no JSON: {error}") from error
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
    except (ArithmeticError, KeyError, TypeError, ValueError) as error:
        return _malformed(error)
    return None


INEXACT = "halving a box is not exact"
EXTRA_HALVINGS = 8  # the guesses of two programs differ, so a leaf may need a cut or two
MARGIN = 0.9e-6  # -, of the level; the prover keeps 1e-6, rounding must not decide


class RejectedError(Exception):
    """The certificate does not prove what it says; the message says where."""


def verify(content: dict[str, Any]) -> str | None:
    """Check a certificate.

    Args:
        content: As read from the file.

    Returns:
        None if every statement in it was confirmed, else what was not.
    """
    try:
        _check(content)
    except (RejectedError, ArithmeticError) as rejection:
        return str(rejection)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        return _malformed(error)
    return None


def _malformed(error: Exception) -> str:
    missing = f"it has no key {error}" if isinstance(error, KeyError) else repr(error)
    return f"malformed certificate: {missing}"


def _check(content: dict[str, Any]) -> None:
    _require(content["format"] == FORMAT, "unknown format")
    _require(content["digest"] == digest(content), "digest does not match")
    problem = content["problem"]
    installed = RELATIVE_MODEL.names
    _require(problem["model"] in installed, f"model {problem['model']!r} is none of {installed}")
    p = _numbers(content["weight"], (NX, NX), "weight")
    k = _numbers(content["gain"], (NU, NX), "gain")
    q = _numbers(problem["state_weight"], (NX, NX), "state_weight")
    r = _numbers(problem["input_weight"], (NU, NU), "input_weight")
    for name, matrix in (("weight", p), ("state_weight", q), ("input_weight", r)):
        _require(np.array_equal(matrix, matrix.T), f"{name} is not symmetric")
        _require(bool(definite(Interval(matrix))), f"{name} is not positive definite")
    level, slack = content["level"], content["slack"]
    _require(np.isfinite(level) and level > 0.0, "level is not positive")
    _require(np.isfinite(slack) and 0.0 <= slack < 1.0, "slack is not in [0, 1)")
    _require(problem["scaling"] >= 1.0, "rho is below 1")

    orbit = Orbit(**problem["orbit"])
    loop = ClosedLoop(problem["model"], problem["scheme"], orbit, float(problem["step_s"]), k)

    inverse = inverse_of(p)
    root = _numbers(content["root"], (NX,), "root")
    for unit, width in zip(np.eye(NX), root, strict=True):
        # The ellipsoid reaches sqrt(varrho (P^-1)_ii) along x_i.
        _require(reach(unit, inverse, level).upper <= width, "root box is too small")
    _check_linear_limits(problem, orbit, k, loop.steady_inputs, inverse, level * (1.0 + MARGIN))

    center, half = _leaves(content["tree"], root)
    multipliers = _numbers(content["multipliers"], (len(center),), "multipliers")
    _require(bool(np.all(multipliers >= 0.0)), "a multiplier is negative")
    _require(content["statistics"]["leaves"] == len(center), "number of leaves is wrong")
    _check_riccati(loop, problem["scaling"], p, stage_weight(q, r, k))

    decrease = decrease_bound(loop, p, q, r, k, slack, level)
    at_origin = np.all(np.abs(center) <= half, axis=1)
    good = decrease.holds_at_origin(center[at_origin], half[at_origin])
    _require(bool(np.all(good)), "decrease not confirmed on a box at the origin")
    rest = _unconfirmed(decrease, center[~at_origin], half[~at_origin], multipliers[~at_origin])
    _require(not len(rest), f"decrease not confirmed on {len(rest)} boxes, first at {rest[:1]}")


def _unconfirmed(
    bound: QuadraticBound,
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    m: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Middles of the boxes away from the origin on which a bound is not confirmed."""
    for _ in range(EXTRA_HALVINGS + 1):
        if not len(center):
            break
        expansion = bound.expansion(center, half)
        guess = bound.guess(center, half, expansion.in_floats(), m)
        bad = ~bound.confirmed(center, half, m, expansion, guess)
        axis = np.argmax(expansion.influence[bad], axis=1)
        center, width, m = center[bad], half[bad], m[bad]
        each = np.arange(len(center))
        width[each, axis] /= 2.0
        shift = np.zeros_like(center)
        shift[each, axis] = width[each, axis]
        lower, upper = center - shift, center + shift
        whole = exact(center, -shift, lower) and exact(center, shift, upper)
        _require(whole and width.all(), INEXACT)
        center = np.concatenate([lower, upper])
        half, m = np.tile(width, (2, 1)), np.tile(m, 2)
    return center


def _check_riccati(
    loop: ClosedLoop, scaling: float, p: NDArray[np.float64], stage: Interval
) -> None:
    """P is what (28) makes of the parameters. Not needed for the proof: it ties P and K to them."""
    _, jacobian = loop.value_and_jacobian(Interval(np.zeros(NX)))
    a_k = jacobian.middle()
    residual = a_k.T @ p @ a_k - p + scaling * stage.middle()
    _require(np.abs(residual).max() < 1e-8 * np.abs(p).max(), "P_rho does not solve (28)")


def _check_linear_limits(
    problem: dict[str, Any],
    orbit: Orbit,
    gain: NDArray[np.float64],
    u_ss: Interval,
    inverse: Interval,
    level: float,
) -> None:
    lower = _numbers(problem["input_lower"], (NU,), "input_lower")
    upper = _numbers(problem["input_upper"], (NU,), "input_upper")
    for i in range(NU):
        swing = reach(gain[i], inverse, level)
        _require((u_ss[i] + swing).upper <= upper[i], f"input {i} exceeds its upper bound")
        _require((u_ss[i] - swing).lower >= lower[i], f"input {i} exceeds its lower bound")
    for sign in (-1.0, 1.0):
        room = Interval(orbit.range) + sign * orbit.altitude
        gap = room - reach(np.array([1.0, 0.0, sign, 0.0, 0.0]), inverse, level)
        _require(gap.lower > 0.0, "range may fall to |height|: outside the model's domain")
    turn = reach(np.eye(NX)[1], inverse, level)
    _require(turn.upper < np.pi, "bearing error may reach half a turn")


def _leaves(
    tree: str, root: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centres and half-widths of the leaves of a tree in preorder, upper half first out last."""
    stack, centers, halves = [(np.zeros(NX), root)], [], []
    for mark in tree:
        _require(bool(stack), "tree is too long")
        center, half = stack.pop()
        if mark == ".":
            centers.append(center)
            halves.append(half)
            continue
        _require(mark in "01234", f"tree has a mark {mark!r}")
        axis, half = int(mark), half.copy()
        half[axis] /= 2.0
        for side in (1.0, -1.0):
            child = center.copy()
            child[axis] += side * half[axis]
            whole = exact(center[axis], side * half[axis], child[axis])
            _require(whole and half[axis] > 0.0, INEXACT)
            stack.append((child, half))
    _require(not stack, "tree is not complete: its leaves do not cover the ellipsoid")
    return np.array(centers), np.array(halves)


def _numbers(values: Any, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    array = np.array(values, dtype=float)
    _require(array.shape == shape and bool(np.all(np.isfinite(array))), f"{name} has wrong entries")
    return array


def _require(condition: Any, message: str) -> None:
    if not condition:
        raise RejectedError(message)
