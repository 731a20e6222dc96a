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

r"""Is the quadratic bound true on one box? Two sufficient tests, both in ball arithmetic.

**Away from the origin.** With c the centre of the box and F(x) = f(x, Kx) - C x, Taylor's theorem
gives F(c + d) = a + J d + e, a = F(c) + mid, J = F'(c), |e_k| <= r_k, where mid and r come from the
Hessians over the whole box. For any t > 0 and m >= 0, with E^2 = max |e|_P^2,

.. math:: |F|_P^2 - x'Nx \le q(d) = (1 + t)|a + Jd|_P^2 + (1 + 1/t) E^2 - x'Nx + m(\alpha - x'Px)

on X_f, since the last bracket is not negative there. Where q is not concave a diagonal D is
added: d'Dd <= sum D_ii h_i^2. A concave q lies below its tangent plane at any point, so the
largest value of the plane on the box bounds it. The numbers t, m, D and the point of tangency are
floating-point guesses: any choice is sound, a bad one only proves less.

So the quadratic part is handled exactly whatever the size of the box; only variables in which the
model curves need be cut small.

**At the origin** the inequality is homogeneous. There F(x) = (F'(0) + G(x)) x with rows
G_k = x'H_k/2, H_k over a box that holds the origin, and the bound follows when

.. math:: N - (F'(0) + G)' P (F'(0) + G) \succ 0

for every G in the enclosure over the box.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.terminal.ball import flint
from uav_tracking_mpc.terminal.box_guess import Guess
from uav_tracking_mpc.terminal.quadratic_bound import QuadraticBound, exact


@dataclass(frozen=True)
class Verdict:
    """Outcome of a test on a box.

    Attributes:
        proved: The bound holds on the box within X_f.
        cut: Otherwise the coordinate to halve next.
        excess: Otherwise the bound found for the left side minus the right one [-].
        multiplier: The m that was best here [-]: where to start on the halves of the box.
    """

    proved: bool
    cut: int = -1
    excess: float = float("nan")
    multiplier: float = 0.0


class BoxTest:
    """Tests of one bound, box after box.

    Args:
        bound: What to prove.

    Raises:
        ArithmeticError: P is not positive definite.
    """

    def __init__(self, bound: QuadraticBound) -> None:
        self.bound = bound
        self._n = len(bound.weight)
        self._p = exact(bound.weight)
        self._level = flint().arb(bound.level)
        if not is_positive_definite(self._p):
            raise ArithmeticError("P is not positive definite")
        self._subtracted = None if bound.subtracted is None else exact(bound.subtracted)
        self._p_float = np.asarray(bound.weight, dtype=float)
        self._n_float = to_float(bound.right)
        self._scale = np.sqrt(np.diag(self._p_float))
        self._abs_p = exact(np.abs(self._p_float))
        whitening = np.linalg.inv(np.linalg.cholesky(self._p_float)).T
        self._whitening = exact(whitening)
        zero = [flint().arb(0)] * self._n
        self._slope_at_origin = self._map(zero)[1]

    def root(self) -> NDArray[np.float64]:
        """Half-widths e of a box [-e, e] that holds X_f: e_i^2 >= varrho (P^-1)_ii, shape (5,).

        They have 24-bit mantissas, so that halving boxes again and again stays exact.
        """
        inverse = self._p.inv()
        return np.array([short_upper((self._level * inverse[i, i]).sqrt()) for i in range(self._n)])

    def __call__(
        self, center: NDArray[np.float64], half: NDArray[np.float64], multiplier: float = 0.0
    ) -> Verdict:
        """Test one box.

        Args:
            center: Its middle, shape (5,), taken as exact doubles.
            half: Its half-widths, shape (5,), likewise.
            multiplier: First guess of m [-].
        """
        arb = flint().arb
        box = [arb(c, h) for c, h in zip(center.tolist(), half.tolist(), strict=True)]
        curvature = self.bound.closed_loop.curvature(box)
        influence = self._influence(curvature, half)
        if not np.all(np.isfinite(influence)):
            return Verdict(False, int(np.argmax(half * self._scale)), float("inf"))
        if np.all(np.abs(center) <= half):
            return self._at_origin(box, curvature, influence)
        return self._by_taylor(center, half, curvature, influence, multiplier)

    def _map(self, x: list[Any]) -> tuple[Any, Any]:
        """Value of F and its derivative F' at x."""
        value, jacobian = self.bound.closed_loop.value_and_jacobian(x)
        column = flint().arb_mat([[entry] for entry in value])
        if self._subtracted is None:
            return column, jacobian
        return column - self._subtracted * _column(x), jacobian - self._subtracted

    def _influence(
        self, curvature: list[list[Any]], half: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """How much each coordinate's width adds to the remainder, in the norm of P (a guess)."""
        influence = np.zeros(self._n)
        for row, (places, entries) in enumerate(
            zip(self.bound.closed_loop.pattern, curvature, strict=True)
        ):
            for (i, j), entry in zip(places, entries, strict=True):
                size = self._scale[row] * float(entry.abs_upper()) * half[i] * half[j]
                influence[i] += 0.25 * size
                influence[j] += 0.25 * size
        return influence

    def _at_origin(
        self, box: list[Any], curvature: list[list[Any]], influence: NDArray[np.float64]
    ) -> Verdict:
        arb, n = flint().arb, self._n
        rows = []
        for places, entries in zip(self.bound.closed_loop.pattern, curvature, strict=True):
            row = [arb(0)] * n
            for (i, j), entry in zip(places, entries, strict=True):
                row[j] = row[j] + box[i] * entry / 2
                if i != j:
                    row[i] = row[i] + box[j] * entry / 2
            rows.append(row)
        slope = self._slope_at_origin + flint().arb_mat(rows)
        gap = self.bound.right - slope.transpose() * self._p * slope
        gap = self._whitening.transpose() * gap * self._whitening
        if is_positive_definite(gap):
            return Verdict(True)
        return Verdict(False, int(np.argmax(influence)), float("nan"))

    def _by_taylor(
        self,
        center: NDArray[np.float64],
        half: NDArray[np.float64],
        curvature: list[list[Any]],
        influence: NDArray[np.float64],
        multiplier: float,
    ) -> Verdict:
        arb, n = flint().arb, self._n
        c, h = [arb(v) for v in center.tolist()], [arb(v) for v in half.tolist()]
        square, product = arb(0.25, 0.25), arb(0, 1)  # d_i^2/2 in h_i^2 [0, 1/2]; d_i d_j
        middle, radius = [], []
        for places, entries in zip(self.bound.closed_loop.pattern, curvature, strict=True):
            remainder = arb(0)
            for (i, j), entry in zip(places, entries, strict=True):
                remainder += entry * h[i] * h[j] * (square if i == j else product)
            middle.append(remainder.mid())
            radius.append(remainder.rad())
        value, jacobian = self._map(c)
        value = value + _column(middle)
        spread = _column(radius)
        error = (spread.transpose() * self._abs_p * spread)[0, 0]

        guess = Guess(
            self._p_float,
            self._n_float,
            self.bound.level,
            center,
            half,
            to_float(value)[:, 0],
            to_float(jacobian),
            float(error),
            multiplier,
        )
        if guess.excess >= 0.0:
            weight = influence * 2.0 * guess.reach + guess.convexifier * half**2
            return Verdict(False, int(np.argmax(weight)), guess.excess, guess.multiplier)

        t, m = arb(guess.young), arb(guess.multiplier)
        point, diagonal = [arb(v) for v in guess.point.tolist()], guess.convexifier.tolist()
        p_jacobian = self._p * jacobian
        curved = self.bound.right + self._p * m - jacobian.transpose() * p_jacobian * (1 + t)
        for i in range(n):
            curved[i, i] = curved[i, i] + arb(diagonal[i])
        if not is_positive_definite(curved):
            return Verdict(False, int(np.argmax(influence)), guess.excess)
        d = _column(point)
        x = _column([ci + di for ci, di in zip(c, point, strict=True)])
        image = value + jacobian * d
        p_image, p_x, n_x = self._p * image, self._p * x, self.bound.right * x
        top = (
            (image.transpose() * p_image)[0, 0] * (1 + t)
            + (error * (1 + 1 / t) if error > 0 else error)
            - (x.transpose() * n_x)[0, 0]
            + m * (self._level - (x.transpose() * p_x)[0, 0])
        )
        slope = jacobian.transpose() * p_image * (1 + t) - n_x - p_x * m
        for i in range(n):
            bend = arb(diagonal[i])
            top += bend * (h[i] * h[i] - point[i] * point[i])
            top += 2 * (slope[i, 0] - bend * point[i]) * (arb(0, 1) * h[i] - point[i])
        if top <= 0:
            return Verdict(True, multiplier=guess.multiplier)
        return Verdict(False, int(np.argmax(influence)), float(top.abs_upper()))


def is_positive_definite(matrix: Any) -> bool:
    """True only if every symmetric matrix in the ``arb_mat`` ``matrix`` is positive definite."""
    n = matrix.nrows()
    rows = [[matrix[i, j] for j in range(i + 1)] for i in range(n)]
    for k in range(n):
        pivot = rows[k][k]
        if not pivot > 0:
            return False
        for i in range(k + 1, n):
            factor = rows[i][k] / pivot
            for j in range(k + 1, i + 1):
                rows[i][j] = rows[i][j] - factor * rows[j][k]
    return True


def short_upper(value: Any) -> float:
    """A double with a 24-bit mantissa that is not below any number of the ball ``value``."""
    upper = float(value.abs_upper())
    mantissa, exponent = np.frexp(upper)
    return float(np.ldexp(np.ceil(mantissa * 2.0**24) + 1.0, int(exponent) - 24))


def to_float(matrix: Any) -> NDArray[np.float64]:
    """Midpoints of the ``arb_mat`` ``matrix``, of its shape."""
    return np.array(
        [[float(matrix[i, j]) for j in range(matrix.ncols())] for i in range(matrix.nrows())]
    )


def _column(entries: list[Any]) -> Any:
    return flint().arb_mat([[entry] for entry in entries])
