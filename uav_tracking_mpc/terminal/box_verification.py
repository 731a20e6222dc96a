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

r"""The checker's test of boxes: does V_f fall as it must on each of them?

On a leaf c + d, \|d_i\| <= h_i, away from the origin, Taylor's f = a + J d + e with \|e\|_P <= E
from the Hessians, so the left side minus the right is at most

.. math:: (1 + t)|a + Jd|_P^2 + (1 + 1/t)E^2 - x'Nx + m(\alpha - x'Px)

with m from the certificate. Made concave by a diagonal, it lies below its tangent plane anywhere.
On a leaf at the origin f = (f'(0) + G)x, and N - (f'(0) + G)'P(f'(0) + G) is positive definite.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.discretisation import error_step
from uav_tracking_mpc.dynamics.relative import NU, NX
from uav_tracking_mpc.terminal.interval import Interval
from uav_tracking_mpc.terminal.interval_matrix import (
    Column,
    Matrix,
    columns,
    constant,
    definite,
    evaluate,
    product,
    quadratic,
    times,
    total,
    transpose,
    unpack,
)

EXTRA_HALVINGS = 8  # the guesses of two programs differ, so a leaf may need a cut or two
_RANGE = range(NX)


class ClosedLoop:
    """f(x, Kx) of (10) in error form, its Jacobian and Hessians, on many boxes at once.

    Args:
        model: Name of a relative model.
        scheme: Name in :data:`uav_tracking_mpc.dynamics.discretisation.SCHEMES`.
        numbers: x_ss, u_ss, K by columns, and T_s.
    """

    def __init__(self, model: str, scheme: str, numbers: Column) -> None:
        x, values = ca.SX.sym("x", NX), ca.SX.sym("numbers", len(numbers))
        x_ss, u_ss, step = values[:NX], values[NX : NX + NU], values[-1]
        gain = ca.reshape(values[NX + NU : -1], NU, NX)
        following = error_step(model, scheme, x, gain @ x, x_ss, u_ss, step)
        self._numbers = numbers
        self._slopes = ca.Function("slopes", [x, values], [following, ca.jacobian(following, x)])
        bends = [ca.hessian(following[i], x)[0] for i in _RANGE]
        self._bends = ca.Function("bends", [x, values], ca.cse(bends))

    def value_and_jacobian(self, x: Column) -> tuple[Column, Matrix]:
        """Enclosures of f and its Jacobian on the box ``x``."""
        value, jacobian = evaluate(self._slopes, [x, self._numbers])
        return value, unpack(self._slopes, 1, jacobian)

    def hessians(self, x: Column) -> list[Matrix]:
        """Enclosures of the Hessians of the components of f on the box ``x``."""
        outputs = evaluate(self._bends, [x, self._numbers])
        return [unpack(self._bends, i, output) for i, output in enumerate(outputs)]


class Decrease:
    """The inequality |f(x, Kx)|_P^2 <= x'Nx on x'Px <= varrho, box by box.

    Args:
        loop: f(x, Kx).
        p: P, shape (5, 5).
        right: N.
        level: varrho [-].
    """

    def __init__(
        self, loop: ClosedLoop, p: NDArray[np.float64], right: Matrix, level: float
    ) -> None:
        self._loop, self._p, self._right, self._level = loop, p, right, level

    def holds_at_origin(
        self, center: NDArray[np.float64], half: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Where the inequality is confirmed, shape (n,), on boxes that hold the origin.

        Args:
            center: Middles of the boxes, shape (n, 5).
            half: Their half-widths, shape (n, 5).
        """
        unit = Interval(-1.0, 1.0)
        box = [c + unit * h for c, h in zip(columns(center), columns(half), strict=True)]
        hessians = self._loop.hessians(box)
        _, slope = self._loop.value_and_jacobian([Interval(0.0)] * NX)
        whole = [
            [slope[k][j] + total(box[i] * hessians[k][i][j] for i in _RANGE) * 0.5 for j in _RANGE]
            for k in _RANGE
        ]
        image = product(transpose(whole), product(constant(self._p), whole))
        gap = [[self._right[i][j] - image[i][j] for j in _RANGE] for i in _RANGE]
        scale = constant(np.linalg.inv(np.linalg.cholesky(self._p)))
        return definite(product(scale, product(gap, transpose(scale))))

    def unconfirmed(
        self, center: NDArray[np.float64], half: NDArray[np.float64], m: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Middles, shape (k, 5), of the boxes on which the inequality is not confirmed.

        Args:
            center: Middles of boxes away from the origin, shape (n, 5).
            half: Their half-widths, shape (n, 5).
            m: Their multipliers, shape (n,).
        """
        for _ in range(EXTRA_HALVINGS + 1):
            if not len(center):
                break
            good, axis = self._test(center, half, m)
            center, width, m, axis = center[~good], half[~good], m[~good], axis[~good]
            each = np.arange(len(center))
            width[each, axis] /= 2.0
            shift = np.zeros_like(center)
            shift[each, axis] = width[each, axis]
            center = np.concatenate([center - shift, center + shift])
            half, m = np.tile(width, (2, 1)), np.tile(m, 2)
        return center

    def _test(
        self, center: NDArray[np.float64], half: NDArray[np.float64], m: NDArray[np.float64]
    ) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
        """Which boxes are confirmed, and the axis along which the model curves most on each."""
        p, right = self._p, self._right
        count, unit = len(center), Interval(-np.ones(len(center)), np.ones(len(center)))
        c, h = columns(center), columns(half)
        box = [ci + unit * hi for ci, hi in zip(c, h, strict=True)]
        value, jacobian = self._loop.value_and_jacobian(c)
        radius = []
        influence = 1e-9 * half * np.sqrt(np.diag(p))
        for k, hessian in enumerate(self._loop.hessians(box)):
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
            [np.stack([np.broadcast_to(e.middle(), count) for e in row], -1) for row in jacobian],
            -2,
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
        top = top + error * (Interval(1.0) + Interval(t).inverse()) + Interval(m) * self._level
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
