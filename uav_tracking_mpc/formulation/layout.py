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
