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

"""Intervals [lower, upper] of doubles, many at a time, every operation rounded outwards.

Columns and matrices of them, and CasADi functions on them, are what a proof rests on. NumPy's
+ - * / and sqrt round to nearest, hence one step of ``nextafter`` outwards encloses them; sin and
cos are trusted to 4 units in the last place.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.symbolic import functions


class Interval:
    """Arrays of intervals. ``nan`` bounds mean "anything", and no comparison with them is true.

    Args:
        lower: Lower bounds, any shape.
        upper: Upper bounds, same shape; equal to ``lower`` by default.
    """

    def __init__(self, lower: ArrayLike, upper: ArrayLike | None = None) -> None:
        self.lower = np.asarray(lower, dtype=float)
        self.upper = self.lower if upper is None else np.asarray(upper, dtype=float)

    @staticmethod
    def _outward(lower: NDArray[np.float64], upper: NDArray[np.float64]) -> Interval:
        return Interval(np.nextafter(lower, -np.inf), np.nextafter(upper, np.inf))

    def __neg__(self) -> Interval:
        return Interval(-self.upper, -self.lower)

    def __add__(self, other: Interval | float) -> Interval:
        other = _interval(other)
        return self._outward(self.lower + other.lower, self.upper + other.upper)

    def __sub__(self, other: Interval | float) -> Interval:
        other = _interval(other)
        return self._outward(self.lower - other.upper, self.upper - other.lower)

    def __mul__(self, other: Interval | float) -> Interval:
        other = _interval(other)
        corners = [x * y for x in (self.lower, self.upper) for y in (other.lower, other.upper)]
        return self._outward(np.minimum.reduce(corners), np.maximum.reduce(corners))

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: float) -> Interval:
        return _interval(other) - self

    def inverse(self) -> Interval:
        """1 / self; nan where it holds 0."""
        holds_zero = ~((self.lower > 0.0) | (self.upper < 0.0))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            result = self._outward(1.0 / self.upper, 1.0 / self.lower)
        return Interval(
            np.where(holds_zero, np.nan, result.lower), np.where(holds_zero, np.nan, result.upper)
        )

    def __truediv__(self, other: Interval | float) -> Interval:
        return self * _interval(other).inverse()

    def square(self) -> Interval:
        """self^2, not below 0."""
        a, b = self.lower * self.lower, self.upper * self.upper
        least = np.where((self.lower <= 0.0) & (self.upper >= 0.0), 0.0, np.minimum(a, b))
        result = self._outward(least, np.maximum(a, b))
        return Interval(np.maximum(result.lower, 0.0), result.upper)

    def sqrt(self) -> Interval:
        """Root; nan where it may be of a negative number."""
        with np.errstate(invalid="ignore"):
            result = self._outward(np.sqrt(self.lower), np.sqrt(self.upper))
        return Interval(np.where(self.lower >= 0.0, result.lower, np.nan), result.upper)

    def sin(self) -> Interval:
        """Sine."""
        return self._wave(np.sin, 0.5 * np.pi)

    def cos(self) -> Interval:
        """Cosine."""
        return self._wave(np.cos, 0.0)

    def _wave(self, function: np.ufunc, crest: float) -> Interval:
        """A wave of period 2 pi, 1 at ``crest``: its end points, +-1 where a crest may lie."""
        a, b = function(self.lower), function(self.upper)
        ulps, turn, near = 1e-15, 2.0 * np.pi, 1e-9
        lower, upper = np.minimum(a, b) - ulps, np.maximum(a, b) + ulps

        def may_hold(place: float) -> NDArray[np.bool_]:
            first = np.ceil((self.lower - near - place) / turn)
            return first * turn + place <= self.upper + near

        with np.errstate(invalid="ignore"):
            lower = np.where(may_hold(crest + np.pi), -1.0, np.maximum(lower, -1.0))
            upper = np.where(may_hold(crest), 1.0, np.minimum(upper, 1.0))
            unknown = ~(np.abs(self.lower) < 1e6) | ~(np.abs(self.upper) < 1e6)
        return Interval(np.where(unknown, np.nan, lower), np.where(unknown, np.nan, upper))

    def magnitude(self) -> NDArray[np.float64]:
        """Largest absolute value of each interval, in the intervals' shape."""
        return np.maximum(np.abs(self.lower), np.abs(self.upper))

    def middle(self) -> NDArray[np.float64]:
        """A double near the middle of each interval, in the intervals' shape."""
        return 0.5 * (self.lower + self.upper)


def _interval(value: Interval | float) -> Interval:
    return value if isinstance(value, Interval) else Interval(value)


Column = list[Interval]
Matrix = list[list[Interval]]


_OPERATIONS: dict[int, Callable[..., Interval]] = {
    ca.OP_ADD: operator.add,
    ca.OP_SUB: operator.sub,
    ca.OP_MUL: operator.mul,
    ca.OP_DIV: operator.truediv,
    ca.OP_NEG: operator.neg,
    ca.OP_SQ: Interval.square,
    ca.OP_TWICE: lambda a: a * 2.0,
    ca.OP_INV: Interval.inverse,
    ca.OP_SQRT: Interval.sqrt,
    ca.OP_SIN: Interval.sin,
    ca.OP_COS: Interval.cos,
}


def evaluate(function: ca.Function, inputs: list[Column]) -> list[Column]:
    """Walk the instructions of a CasADi ``function`` with intervals for its ``inputs``.

    Raises:
        ValueError: An operation that is not known here.
    """

    def applied(code: int, *operands: Interval) -> Interval:
        if code not in _OPERATIONS:
            raise ValueError(f"operation {code} of the model is not known here")
        return _OPERATIONS[code](*operands)

    return functions.evaluate(function, inputs, Interval, applied)


def unpack(function: ca.Function, index: int, entries: Column) -> Matrix:
    """Dense matrix from the nonzeros of one output of a CasADi function; zeros are exact.

    Args:
        function: The function.
        index: Of the output.
        entries: Its nonzeros.
    """
    sparsity = function.sparsity_out(index)
    full = [[Interval(0.0) for _ in range(sparsity.size2())] for _ in range(sparsity.size1())]
    rows, columns = sparsity.get_triplet()
    for i, j, entry in zip(rows, columns, entries, strict=True):
        full[i][j] = entry
    return full


def definite(matrix: Matrix) -> NDArray[np.bool_]:
    """Where every symmetric matrix in an interval ``matrix`` is positive definite (LDL').

    Returns:
        Of the shape of the matrix's intervals.
    """
    rows = [list(row) for row in matrix]
    good: Any = np.asarray(True)
    with np.errstate(invalid="ignore", over="ignore"):
        for k in range(len(rows)):
            pivot = rows[k][k]
            good = good & (pivot.lower > 0.0)
            for i in range(k + 1, len(rows)):
                factor = rows[i][k] / pivot
                for j in range(k + 1, i + 1):
                    rows[i][j] = rows[i][j] - factor * rows[j][k]
    return np.asarray(good)


def inverse_of(p: NDArray[np.float64]) -> Matrix:
    """Enclosure of P^-1: W near it and R = I - PW give |P^-1 - W| <= |W| |R| / (1 - |R|).

    Args:
        p: P, shape (n, n).
    """
    indices = range(len(p))
    w = np.linalg.inv(p)
    w = 0.5 * (w + w.T)
    both = product(constant(p), constant(w))
    squares = total(
        (Interval(float(i == j)) - both[i][j]).square() for i in indices for j in indices
    )
    residual = Interval(0.0, squares.upper).sqrt()
    if not residual.upper < 1e-3:
        raise ValueError("P cannot be inverted")
    size = total(Interval(v).square() for v in w.ravel()).sqrt()
    radius = (size * residual / (Interval(1.0) - residual)).upper
    return [[Interval(w[i, j]) + Interval(-radius, radius) for j in indices] for i in indices]


def reach(row: NDArray[np.float64], inverse: Matrix, level: float) -> Interval:
    """Largest c'x over x'Px <= level: sqrt(level c'P^-1 c).

    Args:
        row: c, shape (n,).
        inverse: Enclosure of P^-1.
        level: varrho [-].
    """
    return (quadratic(inverse, [Interval(v) for v in row]) * level).sqrt()


def constant(values: NDArray[np.float64]) -> Matrix:
    """Matrix of the numbers ``values``, shape (n, m), taken as exact."""
    return [[Interval(entry) for entry in row] for row in values]


def columns(values: NDArray[np.float64]) -> Column:
    """Columns of ``values``, shape (m, n): n intervals of m numbers each."""
    return [Interval(values[:, i]) for i in range(values.shape[1])]


def transpose(matrix: Matrix) -> Matrix:
    """The ``matrix`` transposed."""
    return [list(row) for row in zip(*matrix, strict=True)]


def product(left: Matrix, right: Matrix) -> Matrix:
    """Product of the matrices ``left`` and ``right``."""
    columns = transpose(right)
    return [
        [total(a * b for a, b in zip(row, column, strict=True)) for column in columns]
        for row in left
    ]


def times(matrix: Matrix, column: Column) -> Column:
    """Product of ``matrix`` and ``column``."""
    return [total(a * b for a, b in zip(row, column, strict=True)) for row in matrix]


def quadratic(matrix: Matrix, column: Column) -> Interval:
    """Quadratic form x'Mx of the ``matrix`` M at the ``column`` x."""
    return total(a * b for a, b in zip(column, times(matrix, column), strict=True))


def total(terms: Any) -> Interval:
    """Sum of the intervals ``terms``."""
    total = Interval(0.0)
    for term in terms:
        total = total + term
    return total
