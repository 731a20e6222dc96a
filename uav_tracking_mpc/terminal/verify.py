"""Check a certificate from scratch: a short program that knows nothing of how the proof was found.

It shares no code with the prover beyond the models in ``dynamics``, and not the arithmetic either:
intervals of doubles here, balls there. In order it checks that

1. the content is complete, its digest right, P, Q and R positive definite, rho at least 1;
2. the root box holds the ellipsoid, and the tree of halved boxes is complete: its leaves cover it;
3. inputs stay in U and states in the model's domain on the ellipsoid;
4. on every leaf V_f(f(x, Kx)) - V_f(x) + L(x, Kx) <= -slack V_f(x) within the ellipsoid.

4, for a leaf c + d, |d_i| <= h_i: Taylor's f = a + J d + e with |e|_P <= E from the Hessians, so
the left side minus the right is at most (1 + t)|a + Jd|_P^2 + (1 + 1/t)E^2 - x'Nx + m(varrho -
x'Px) with m from the certificate. Made concave by a diagonal, it lies below its tangent plane
anywhere. A leaf at the origin: f = (f'(0) + G)x, and N - (f'(0) + G)'P(f'(0) + G) is positive
definite.
"""

from __future__ import annotations

import hashlib
import json
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.discretisation import SCHEMES
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.relative import NU, NX, rates_function
from uav_tracking_mpc.terminal.interval import Interval
from uav_tracking_mpc.terminal.interval_matrix import (
    Column,
    Matrix,
    columns,
    constant,
    definite,
    evaluate,
    inverse_of,
    product,
    quadratic,
    reach,
    times,
    total,
    transpose,
    unpack,
)

KNOWN_FORMAT = "uav_tracking_mpc terminal set certificate 1"
EXTRA_HALVINGS = 8
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
    for i in (0, 2, 3, 4):
        _require(drift[i].magnitude() < 1e-9, f"rate {i} does not vanish on the orbit")
    u_ss = [-drift[1], Interval(0.0), Interval(0.0)]

    inverse = inverse_of(p)
    root = _numbers(content["root"], (NX,), "root")
    for i in _RANGE:  # the ellipsoid reaches sqrt(varrho (P^-1)_ii) along x_i
        _require(reach(np.eye(NX)[i], inverse, level).upper <= root[i], "root box is too small")
    _check_linear_limits(problem, orbit, k, u_ss, inverse, level)

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
    loop = _ClosedLoop(problem["model"], problem["scheme"], numbers)

    _check_riccati(loop, problem["scaling"], p, stage)

    at_origin = np.all(np.abs(center) <= half, axis=1)
    if np.any(at_origin):
        good = _test_origin(loop, p, right, center[at_origin], half[at_origin])
        _require(bool(np.all(good)), "decrease not confirmed on a box at the origin")
    rest = (center[~at_origin], half[~at_origin], multipliers[~at_origin])
    for _ in range(EXTRA_HALVINGS + 1):
        if not len(rest[0]):
            return
        good, axis = _test_taylor(loop, p, right, level, *rest)
        rest = _halve(rest[0][~good], rest[1][~good], rest[2][~good], axis[~good])
    raise RejectedError(f"decrease not confirmed on {len(rest[0])} boxes, first at {rest[0][0]}")


def _check_riccati(
    loop: _ClosedLoop, scaling: float, p: NDArray[np.float64], stage: Matrix
) -> None:
    """P is what (28) makes of the parameters. Not needed for the proof: it ties P and K to them."""
    _, jacobian = loop.value_and_jacobian([Interval(0.0)] * NX)
    a_k = np.array([[float(entry.middle()) for entry in row] for row in jacobian])
    star = np.array([[float(entry.middle()) for entry in row] for row in stage])
    residual = a_k.T @ p @ a_k - p + scaling * star
    _require(np.abs(residual).max() < 1e-8 * np.abs(p).max(), "P_rho does not solve (28)")


def _halve(
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    multiplier: NDArray[np.float64],
    axis: NDArray[np.intp],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Halves of boxes: guesses differ between two programs, a leaf may need a cut or two."""
    each = np.arange(len(center))
    width = half.copy()
    width[each, axis] /= 2.0
    shift = np.zeros_like(center)
    shift[each, axis] = width[each, axis]
    both = np.concatenate([center - shift, center + shift])
    return both, np.concatenate([width, width]), np.concatenate([multiplier, multiplier])


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


class _ClosedLoop:
    """f(x, Kx), its Jacobian and Hessians, on many boxes at once."""

    def __init__(self, model: str, scheme: str, numbers: Column) -> None:
        x, values = ca.SX.sym("x", NX), ca.SX.sym("numbers", len(numbers))
        x_ss, u_ss, step = values[:NX], values[NX : NX + NU], values[-1]
        gain = ca.reshape(values[NX + NU : -1], NU, NX)
        following = SCHEMES[scheme](rates_function(model), x + x_ss, u_ss + gain @ x, step) - x_ss  # type: ignore[arg-type]
        self.numbers = numbers
        self.slopes = ca.Function("slopes", [x, values], [following, ca.jacobian(following, x)])
        bends = [ca.hessian(following[i], x)[0] for i in _RANGE]
        self.bends = ca.Function("bends", [x, values], ca.cse(bends))

    def value_and_jacobian(self, x: Column) -> tuple[Column, Matrix]:
        value, jacobian = evaluate(self.slopes, [x, self.numbers])
        return value, unpack(self.slopes, 1, jacobian)

    def hessians(self, x: Column) -> list[Matrix]:
        outputs = evaluate(self.bends, [x, self.numbers])
        return [unpack(self.bends, i, output) for i, output in enumerate(outputs)]


def _test_origin(
    loop: _ClosedLoop,
    p: NDArray[np.float64],
    right: Matrix,
    center: NDArray[np.float64],
    half: NDArray[np.float64],
) -> NDArray[np.bool_]:
    unit = Interval(-1.0, 1.0)
    box = [c + unit * h for c, h in zip(columns(center), columns(half), strict=True)]
    hessians = loop.hessians(box)
    _, slope = loop.value_and_jacobian([Interval(0.0)] * NX)
    whole = [
        [slope[k][j] + total(box[i] * hessians[k][i][j] for i in _RANGE) * 0.5 for j in _RANGE]
        for k in _RANGE
    ]
    image = product(transpose(whole), product(constant(p), whole))
    gap = [[right[i][j] - image[i][j] for j in _RANGE] for i in _RANGE]
    scale = constant(np.linalg.inv(np.linalg.cholesky(p)))
    return definite(product(scale, product(gap, transpose(scale))))


def _test_taylor(
    loop: _ClosedLoop,
    p: NDArray[np.float64],
    right: Matrix,
    level: float,
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    m: NDArray[np.float64],
) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Which boxes are confirmed, and for the others the axis along which the model curves most."""
    count, unit = len(center), Interval(-np.ones(len(center)), np.ones(len(center)))
    c, h = columns(center), columns(half)
    box = [ci + unit * hi for ci, hi in zip(c, h, strict=True)]
    value, jacobian = loop.value_and_jacobian(c)
    radius = []
    influence = 1e-9 * half * np.sqrt(np.diag(p))
    for k, hessian in enumerate(loop.hessians(box)):
        remainder = Interval(np.zeros(count))
        for i in _RANGE:
            remainder = remainder + hessian[i][i] * h[i].square() * Interval(0.0, 0.5)
            for j in range(i):
                remainder = remainder + hessian[i][j] * h[i] * h[j] * unit
            for j in _RANGE:
                size = hessian[i][j].magnitude() * half[:, i] * half[:, j]
                influence[:, i] += np.sqrt(p[k, k]) * np.nan_to_num(size, nan=0.0)
        middle = Interval(remainder.middle())
        value[k] = value[k] + middle
        radius.append(Interval((remainder - middle).magnitude()))
    error = quadratic(constant(np.abs(p)), radius)

    right_float = np.array([[entry.middle() for entry in row] for row in right])
    a = np.stack([entry.middle() for entry in value], axis=-1)
    jf = np.stack(
        [np.stack([np.broadcast_to(e.middle(), count) for e in row], -1) for row in jacobian], -2
    )
    t, bend, point = _guess(p, right_float, center, half, a, jf, error.upper, m)

    young, d, diagonal = Interval(t) + 1.0, columns(point), columns(bend)
    big = [[right[i][j] + Interval(p[i, j]) * Interval(m) for j in _RANGE] for i in _RANGE]
    squared = product(transpose(jacobian), product(constant(p), jacobian))
    curved = [[big[i][j] - squared[i][j] * young for j in _RANGE] for i in _RANGE]
    for i in _RANGE:
        curved[i][i] = curved[i][i] + diagonal[i]
    concave = definite([[curved[i][j] * h[i] * h[j] for j in _RANGE] for i in _RANGE])
    x = [ci + di for ci, di in zip(c, d, strict=True)]
    image = [v + w for v, w in zip(value, times(jacobian, d), strict=True)]
    p_image, big_x = times(constant(p), image), times(big, x)
    top = total(v * w for v, w in zip(image, p_image, strict=True)) * young
    top = top + error * (Interval(1.0) + Interval(t).inverse()) + Interval(m) * level
    top = top - total(v * w for v, w in zip(x, big_x, strict=True))
    pulled = times(transpose(jacobian), p_image)
    for i in _RANGE:
        slope = pulled[i] * young - big_x[i] - diagonal[i] * d[i]
        top = top + diagonal[i] * (h[i].square() - d[i].square())
        top = top + 2.0 * slope * (unit * h[i] - d[i])
    return concave & (top.upper <= 0.0), np.argmax(influence, axis=1)


def _guess(
    p: NDArray[np.float64],
    right: NDArray[np.float64],
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    a: NDArray[np.float64],
    jacobian: NDArray[np.float64],
    error: NDArray[np.float64],
    m: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Young's t, the diagonal and the point of tangency, in plain floating point: any will do."""
    big = right + m[:, None, None] * p
    squared = np.einsum("mki,kl,mlj->mij", jacobian, p, jacobian)
    pulled = np.einsum("mki,kl,ml->mi", jacobian, p, a)
    error = np.nan_to_num(error, nan=1e30, posinf=1e30)
    point = np.zeros_like(center)
    bend = np.zeros_like(center)
    t = np.full(len(center), 1e-9)
    axes = np.arange(NX)
    for _ in range(4):
        image = a + np.einsum("mij,mj->mi", jacobian, point)
        reach = np.sqrt(np.einsum("mi,ij,mj->m", image, p, image))
        t = np.clip(np.sqrt(error) / np.maximum(reach, 1e-150), 1e-9, 1.0)
        curved = np.nan_to_num(big - (1.0 + t)[:, None, None] * squared)
        scaled = curved * half[:, :, None] * half[:, None, :]
        values, vectors = np.linalg.eigh(scaled)
        floor = 1e-7 * np.abs(values[:, -1:])
        lacking = np.where(values <= floor, floor - values, 0.0)
        sizes = np.abs(vectors)
        bend = np.einsum("mk,mik,mk->mi", lacking, sizes, sizes.sum(axis=1))
        bend = (
            np.where(np.any(lacking > 0.0, axis=1, keepdims=True), 1.001 * bend + floor, 0.0)
            / half**2
        )
        curved[:, axes, axes] += bend
        linear = (1.0 + t)[:, None] * pulled - np.einsum("mij,mj->mi", big, center)
        for _ in range(200):
            for i in _RANGE:
                rest = linear[:, i] - np.einsum("mj,mj->m", curved[:, i], point)
                rest += curved[:, i, i] * point[:, i]
                best = rest / np.maximum(curved[:, i, i], 1e-300)
                point[:, i] = np.clip(np.nan_to_num(best), -half[:, i], half[:, i])
    return t, bend, point


def _numbers(values: Any, shape: tuple[int, ...], name: str) -> NDArray[np.float64]:
    array = np.array(values, dtype=float)
    _require(array.shape == shape and bool(np.all(np.isfinite(array))), f"{name} has wrong entries")
    return array


def _require(condition: Any, message: str) -> None:
    if not condition:
        raise RejectedError(message)
