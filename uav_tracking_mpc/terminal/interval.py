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

The checker's own arithmetic: the proofs use balls (``ball``), so an error in one arithmetic does
not hide in the other. NumPy's + - * / and sqrt round to nearest, hence one step of ``nextafter``
outwards encloses them; sin and cos are trusted to 4 units in the last place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


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
        with np.errstate(divide="ignore", invalid="ignore"):
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
