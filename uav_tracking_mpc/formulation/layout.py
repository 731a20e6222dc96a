"""Named parts of a parameter vector."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


class Layout:
    """Where each named part stands in a vector.

    Args:
        sizes: Length of each part, in the order of the vector.

    Attributes:
        where: Slice of each part.
        size: Length of the vector.
    """

    def __init__(self, sizes: Mapping[str, int]) -> None:
        self.where: dict[str, slice] = {}
        begin = 0
        for name, size in sizes.items():
            self.where[name] = slice(begin, begin + size)
            begin += size
        self.size = begin

    def part(self, vector: Any, name: str) -> Any:
        """One part of a vector.

        Args:
            vector: Shape (size,) or (size, n), numbers or symbols.
            name: Of the part.

        Returns:
            Shape (k,) or (k, n): a view where the vector is an array.
        """
        return vector[self.where[name]]
