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

Vectors and matrices of them, and CasADi functions on them, are what a proof rests on: arrays whose
last axis or two are those of the vector or matrix, and whose first is that of the boxes. NumPy's
+ - * / and sqrt round to nearest, hence one step of ``nextafter`` outwards encloses them; sin and
cos are trusted to 4 units in the last place.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
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

    __array_ufunc__ = None  # an array beside an operator leaves the operation to the interval

    def __init__(self, lower: ArrayLike, upper: ArrayLike | None = None) -> None:
        self.lower = np.asarray(lower, dtype=float)
        self.upper = self.lower if upper is None else np.asarray(upper, dtype=float)

    @staticmethod
    def _outward(lower: NDArray[np.float64], upper: NDArray[np.float64]) -> Interval:
        return Interval(np.nextafter(lower, -np.inf), np.nextafter(upper, np.inf))

    def __getitem__(self, key: Any) -> Interval:
        return Interval(self.lower[key], self.upper[key])

    @property
    def flattened(self) -> Interval:
        """All of them as one vector."""
        return Interval(self.lower.ravel(), self.upper.ravel())

    @property
    def transposed(self) -> Interval:
        """The matrices with rows for columns."""
        return Interval(np.swapaxes(self.lower, -1, -2), np.swapaxes(self.upper, -1, -2))

    def __neg__(self) -> Interval:
        return Interval(-self.upper, -self.lower)

    def __add__(self, other: Interval | ArrayLike) -> Interval:
        other = _interval(other)
        return self._outward(self.lower + other.lower, self.upper + other.upper)

    def __sub__(self, other: Interval | ArrayLike) -> Interval:
        other = _interval(other)
        return self._outward(self.lower - other.upper, self.upper - other.lower)

    def __mul__(self, other: Interval | ArrayLike) -> Interval:
        other = _interval(other)
        corners = [x * y for x in (self.lower, self.upper) for y in (other.lower, other.upper)]
        return self._outward(np.minimum.reduce(corners), np.maximum.reduce(corners))

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other: ArrayLike) -> Interval:
        return _interval(other) - self

    def inverse(self) -> Interval:
        """1 / self; nan where it holds 0."""
        holds_zero = ~((self.lower > 0.0) | (self.upper < 0.0))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            result = self._outward(1.0 / self.upper, 1.0 / self.lower)
        return Interval(
            np.where(holds_zero, np.nan, result.lower), np.where(holds_zero, np.nan, result.upper)
        )

    def __truediv__(self, other: Interval | ArrayLike) -> Interval:
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


def _interval(value: Interval | ArrayLike) -> Interval:
    return value if isinstance(value, Interval) else Interval(value)


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


def evaluate(function: ca.Function, inputs: Sequence[Interval]) -> list[Interval]:
    """Walk the instructions of a CasADi ``function`` with vectors of intervals for its ``inputs``.

    Returns:
        Of each output a vector, or a matrix where it has several columns; its zeros are exact.

    Raises:
        ValueError: An operation that is not known here.
    """

    def applied(code: int, *operands: Interval) -> Interval:
        if code not in _OPERATIONS:
            raise ValueError(f"operation {code} of the model is not known here")
        return _OPERATIONS[code](*operands)

    entries = [[values[..., i] for i in range(values.lower.shape[-1])] for values in inputs]
    outputs = []
    for index, nonzeros in enumerate(functions.evaluate(function, entries, Interval, applied)):
        sparsity = function.sparsity_out(index)
        full = [Interval(0.0)] * sparsity.numel()
        for place, entry in zip(sparsity.find(), nonzeros, strict=True):
            full[place] = entry
        found = vector(full)
        if sparsity.size2() > 1:
            shape = (*found.lower.shape[:-1], sparsity.size2(), sparsity.size1())
            found = Interval(found.lower.reshape(shape), found.upper.reshape(shape)).transposed
        outputs.append(found)
    return outputs


def vector(entries: Sequence[Interval | float]) -> Interval:
    """A vector of ``entries``, of as many boxes as the one with most of them."""
    known = [_interval(entry) for entry in entries]
    lower, upper = (
        np.stack(np.broadcast_arrays(*bounds), axis=-1)
        for bounds in ([entry.lower for entry in known], [entry.upper for entry in known])
    )
    return Interval(lower, upper)


def definite(matrix: Interval) -> NDArray[np.bool_]:
    """Where every symmetric matrix in an interval ``matrix`` is positive definite (LDL').

    Returns:
        Of the shape of the boxes.
    """
    good = np.asarray(True)
    with np.errstate(invalid="ignore", over="ignore"):
        for _ in range(matrix.lower.shape[-1]):
            pivot, column = matrix[..., 0, 0], matrix[..., 1:, 0]
            good = good & (pivot.lower > 0.0)
            factor = column / pivot[..., None]
            matrix = matrix[..., 1:, 1:] - factor[..., :, None] * column[..., None, :]
    return np.asarray(good)


def with_diagonal(matrix: Interval, added: Interval) -> Interval:
    """A ``matrix`` to whose diagonal a vector is ``added``."""
    axes = np.arange(matrix.lower.shape[-1])
    diagonal = matrix[..., axes, axes] + added
    lower, upper = matrix.lower.copy(), matrix.upper.copy()
    lower[..., axes, axes], upper[..., axes, axes] = diagonal.lower, diagonal.upper
    return Interval(lower, upper)


def inverse_of(p: NDArray[np.float64]) -> Interval:
    """Enclosure of P^-1: W near it and R = I - PW give |P^-1 - W| <= |W| |R| / (1 - |R|).

    Args:
        p: P, shape (n, n).
    """
    w = np.linalg.inv(p)
    w = 0.5 * (w + w.T)
    squares = (np.eye(len(p)) - product(Interval(p), Interval(w))).square()
    residual = Interval(0.0, total(squares.flattened).upper).sqrt()
    if not residual.upper < 1e-3:
        raise ValueError("P cannot be inverted")
    size = total(Interval(w.ravel()).square()).sqrt()
    radius = (size * residual / (1.0 - residual)).upper
    return Interval(w) + Interval(-radius, radius)


def reach(row: ArrayLike, inverse: Interval, level: float) -> Interval:
    """Largest c'x over x'Px <= level: sqrt(level c'P^-1 c).

    Args:
        row: c, shape (n,).
        inverse: Enclosure of P^-1.
        level: varrho [-].
    """
    return (quadratic(inverse, Interval(row)) * level).sqrt()


def product(left: Interval, right: Interval) -> Interval:
    """Product of the matrices ``left`` and ``right``."""
    return total(left[..., :, None, :] * right.transposed[..., None, :, :])


def times(matrix: Interval, column: Interval) -> Interval:
    """Product of ``matrix`` and the vector ``column``."""
    return total(matrix * column[..., None, :])


def dot(left: Interval, right: Interval) -> Interval:
    """Product of the vectors ``left`` and ``right``."""
    return total(left * right)


def quadratic(matrix: Interval, column: Interval) -> Interval:
    """Quadratic form x'Mx of the ``matrix`` M at the vector ``column`` x."""
    return dot(column, times(matrix, column))


def exact(
    center: NDArray[np.float64], part: NDArray[np.float64], total: NDArray[np.float64]
) -> bool:
    """Whether ``center`` + ``part`` is their rounded sum ``total``: its error is 0."""
    back = total - center
    return not np.any((center - (total - back)) + (part - back))


def total(terms: Interval) -> Interval:
    """Sum of the intervals ``terms`` along the last axis."""
    total = Interval(0.0)
    for k in range(terms.lower.shape[-1]):
        total = total + terms[..., k]
    return total
