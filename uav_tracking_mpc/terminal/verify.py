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

"""Check a certificate from scratch: a short program that knows nothing of how the proof was found.

It shares no code with the prover beyond ``dynamics`` (the models, one step of them) and CasADi's
derivatives of them, and not the arithmetic either: intervals of doubles here, balls there. A model
must be installed: no file that a certificate names is run. In order it checks that

1. the content is complete, its digest right, P, Q and R positive definite, rho at least 1, and the
   orbit steady by the structure of the model;
2. the root box holds the ellipsoid, and the tree of halved boxes is complete: its leaves cover it;
3. inputs stay in U and states in the model's domain on the ellipsoid, with a margin that covers P
   and K recomputed elsewhere;
4. on every leaf V_f(f(x, Kx)) - V_f(x) + L(x, Kx) <= -slack V_f(x) within the ellipsoid
   (``box_verification``).
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import NU, NX, rates_function, vanishing_rates
from uav_tracking_mpc.parameters.registry import RELATIVE_MODEL
from uav_tracking_mpc.terminal.box_verification import ClosedLoop, Decrease
from uav_tracking_mpc.terminal.interval import Interval
from uav_tracking_mpc.terminal.interval_matrix import (
    Column,
    Matrix,
    constant,
    definite,
    evaluate,
    inverse_of,
    product,
    reach,
)

KNOWN_FORMAT = "uav_tracking_mpc terminal set certificate 1"
MARGIN = 0.9e-6  # of the level; the prover keeps 1e-6, rounding must not decide
_RANGE = range(NX)


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
    except RejectedError as rejection:
        return str(rejection)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
        return f"malformed: {error!r}"
    return None


def _check(content: dict[str, Any]) -> None:
    _require(content["format"] == KNOWN_FORMAT, "unknown format")
    bare = {key: value for key, value in content.items() if key != "digest"}
    text = json.dumps(bare, sort_keys=True, separators=(",", ":"), allow_nan=False)
    _require(
        hashlib.sha256(text.encode()).hexdigest() == content["digest"], "digest does not match"
    )
    problem = content["problem"]
    installed = RELATIVE_MODEL.names
    _require(problem["model"] in installed, f"model {problem['model']!r} is none of {installed}")
    p = _numbers(content["weight"], (NX, NX), "weight")
    k = _numbers(content["gain"], (NU, NX), "gain")
    q = _numbers(problem["state_weight"], (NX, NX), "state_weight")
    r = _numbers(problem["input_weight"], (NU, NU), "input_weight")
    for name, matrix in (("weight", p), ("state_weight", q), ("input_weight", r)):
        _require(np.array_equal(matrix, matrix.T), f"{name} is not symmetric")
        _require(bool(np.all(definite(constant(matrix)))), f"{name} is not positive definite")
    level, slack = float(content["level"]), float(content["slack"])
    _require(np.isfinite(level) and level > 0.0, "level is not positive")
    _require(np.isfinite(slack) and 0.0 <= slack < 1.0, "slack is not in [0, 1)")
    _require(problem["scaling"] >= 1.0, "rho is below 1")

    orbit = Orbit(**problem["orbit"])
    half_turn = Interval(np.nextafter(np.pi, 3.0), np.nextafter(np.pi, 4.0))
    bearing = half_turn * 0.5 if orbit.direction == "clockwise" else half_turn * -0.5
    place = [Interval(orbit.range), bearing, Interval(orbit.altitude), Interval(0.0)]
    place.append(Interval(orbit.speed))
    drift = evaluate(rates_function(problem["model"]), [place, [Interval(0.0)] * NU])[0]
    for i, vanishes in enumerate(vanishing_rates(problem["model"])):
        _require(i == 1 or vanishes, f"rate {i} does not vanish on the orbit")
    u_ss = [-drift[1], Interval(0.0), Interval(0.0)]

    inverse = inverse_of(p)
    root = _numbers(content["root"], (NX,), "root")
    for i in _RANGE:  # the ellipsoid reaches sqrt(varrho (P^-1)_ii) along x_i
        _require(reach(np.eye(NX)[i], inverse, level).upper <= root[i], "root box is too small")
    _check_linear_limits(problem, orbit, k, u_ss, inverse, level * (1.0 + MARGIN))

    center, half = _leaves(content["tree"], root)
    multipliers = _numbers(content["multipliers"], (len(center),), "multipliers")
    _require(bool(np.all(multipliers >= 0.0)), "a multiplier is negative")
    _require(content["statistics"]["leaves"] == len(center), "number of leaves is wrong")
    stage = constant(q)
    for i, row in enumerate(product(constant(k.T), product(constant(r), constant(k)))):
        stage[i] = [a + b for a, b in zip(stage[i], row, strict=True)]
    right = [
        [Interval(p[i, j]) * (Interval(1.0) - slack) - stage[i][j] for j in _RANGE] for i in _RANGE
    ]
    numbers: Column = [*place, *u_ss, *(Interval(v) for v in k.ravel(order="F"))]
    numbers.append(Interval(float(problem["step_s"])))
    loop = ClosedLoop(problem["model"], problem["scheme"], numbers)

    _check_riccati(loop, problem["scaling"], p, stage)

    decrease = Decrease(loop, p, right, level)
    at_origin = np.all(np.abs(center) <= half, axis=1)
    good = decrease.holds_at_origin(center[at_origin], half[at_origin])
    _require(bool(np.all(good)), "decrease not confirmed on a box at the origin")
    rest = decrease.unconfirmed(center[~at_origin], half[~at_origin], multipliers[~at_origin])
    _require(not len(rest), f"decrease not confirmed on {len(rest)} boxes, first at {rest[:1]}")


def _check_riccati(loop: ClosedLoop, scaling: float, p: NDArray[np.float64], stage: Matrix) -> None:
    """P is what (28) makes of the parameters. Not needed for the proof: it ties P and K to them."""
    _, jacobian = loop.value_and_jacobian([Interval(0.0)] * NX)
    a_k = np.array([[float(entry.middle()) for entry in row] for row in jacobian])
    star = np.array([[float(entry.middle()) for entry in row] for row in stage])
    residual = a_k.T @ p @ a_k - p + scaling * star
    _require(np.abs(residual).max() < 1e-8 * np.abs(p).max(), "P_rho does not solve (28)")


def _check_linear_limits(
    problem: dict[str, Any],
    orbit: Orbit,
    gain: NDArray[np.float64],
    u_ss: Column,
    inverse: Matrix,
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
            part, back = side * half[axis], child[axis] - center[axis]
            lost = (center[axis] - (child[axis] - back)) + (part - back)  # of the rounded sum
            _require(lost == 0.0 and half[axis] > 0.0, "halving a box is not exact")
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
