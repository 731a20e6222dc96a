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

"""Names for the parts of a flat vector, of numbers or of symbols alike."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike, NDArray


class Layout:
    """Parts of a vector that follow each other.

    Args:
        parts: By its name how many numbers a part has, the numbers that it begins with where they
            are not all 0, or of which parts it consists itself.

    Attributes:
        size: How many numbers they have together.
        begin: The numbers that they begin with, shape (size,).
    """

    def __init__(self, **parts: int | ArrayLike | Layout) -> None:
        self._inner = {name: part for name, part in parts.items() if isinstance(part, Layout)}
        begins = [_begin(part) for part in parts.values()]
        self._slices: dict[str, slice] = {}
        self.size = 0
        for name, begin in zip(parts, begins, strict=True):
            self._slices[name] = slice(self.size, self.size + len(begin))
            self.size += len(begin)
        self.begin = np.concatenate(begins)

    def parts(self, vector: Any) -> SimpleNamespace:
        """The parts by name: views of an array, or pieces of a column of symbols.

        Args:
            vector: Shape (size,), or a CasADi column.
        """
        pieces = {name: vector[place] for name, place in self._slices.items()}
        inner = {name: part.parts(pieces[name]) for name, part in self._inner.items()}
        return SimpleNamespace(**pieces | inner)

    def part(self, name: str, vector: Any) -> Any:
        """One part as a whole: a view of an array, or a piece of a column.

        Args:
            name: Of the part.
            vector: Shape (size,), or a CasADi column.
        """
        return vector[self._slices[name]]

    def symbol(self, name: str) -> tuple[ca.SX, SimpleNamespace]:
        """A column of new symbols, and its parts.

        Args:
            name: That expressions print.
        """
        vector = ca.SX.sym(name, self.size)
        return vector, self.parts(vector)

    def joined(self, parts: SimpleNamespace) -> ca.SX:
        """The dense column of these parts.

        Args:
            parts: Expressions, each with as many entries as its size says.
        """
        inner = {name: part.joined(getattr(parts, name)) for name, part in self._inner.items()}
        pieces = vars(parts) | inner
        return ca.densify(ca.vertcat(*[pieces[name] for name in self._slices]))


def _begin(part: int | ArrayLike | Layout) -> NDArray[np.float64]:
    if isinstance(part, Layout):
        return part.begin
    return np.zeros(part) if isinstance(part, int) else np.asarray(part, dtype=float)
