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

"""Parameters as an autopilot keeps them: names of at most 16 letters, integers and floats."""

from __future__ import annotations

import math
from collections.abc import Mapping

LARGEST = 2**31 - 1  # of the integers that PARAM_VALUE can hold


class OnboardParameters:
    """Values by name, in a fixed order; a value keeps the type of its default.

    Args:
        defaults: Value of each at the start [-].
    """

    def __init__(self, defaults: Mapping[str, float]) -> None:
        self._defaults = dict(defaults)
        self._values = dict(sorted(defaults.items()))

    @property
    def names(self) -> list[str]:
        """All names, in the order of their index."""
        return list(self._values)

    def __contains__(self, name: str) -> bool:
        return name in self._values

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def integer(self, name: str) -> bool:
        """Whether a parameter is an integer.

        Args:
            name: One that exists.
        """
        return isinstance(self._defaults[name], int)

    def set(self, name: str, value: float) -> bool:
        """Change a value.

        Args:
            name: Of the parameter.
            value: New one [-]; rounded where the parameter is an integer.

        Returns:
            Whether there is such a parameter and the value is finite.
        """
        if name not in self._values or not math.isfinite(value):
            return False
        if self.integer(name):
            value = min(max(round(value), -LARGEST - 1), LARGEST)
        self._values[name] = value
        return True
