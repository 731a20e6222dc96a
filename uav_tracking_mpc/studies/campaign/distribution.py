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

"""How a value is drawn: a few distributions, written in YAML as ``name: [arguments]``.

================  ================================================================
``3.0``           always this
``uniform``       [least, greatest]
``log_uniform``   [least, greatest], both positive, uniform in the logarithm
``normal``        [mean, standard deviation]
``choice``        one of the list, all alike
``values``        swept: each of the list in turn
``grid``          swept: [first, last, how many], evenly spaced
================  ================================================================
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from uav_tracking_mpc.parameters.specification import ParameterError

CONSTANT, CHOICE, SWEPT = "constant", "choice", "values"
# Number of arguments; 0 for any but none.
KINDS = {"uniform": 2, "log_uniform": 2, "normal": 2, CHOICE: 0, SWEPT: 0, "grid": 3}


@dataclass(frozen=True)
class Distribution:
    """One of the above.

    Attributes:
        kind: Name of the distribution; a grid is kept as its values.
        arguments: As in YAML.
    """

    kind: str
    arguments: tuple[Any, ...]

    @classmethod
    def of(cls, key: str, written: Any) -> Distribution:
        """The distribution that YAML holds.

        Args:
            key: Of what it is, for the message of an error.
            written: A value, or a mapping of one name to its arguments.

        Raises:
            ParameterError: Unknown, or with arguments that make no distribution.
        """
        if not isinstance(written, Mapping):
            return cls(CONSTANT, (written,))
        kind, arguments = next(iter(written.items()), ("", ()))
        if len(written) != 1 or kind not in KINDS or not isinstance(arguments, list):
            raise ParameterError(
                f"'{key}' is {written!r}, must be a value or one of {', '.join(KINDS)} with a "
                "list, such as {uniform: [0.0, 1.0]}"
            )
        if not arguments or (KINDS[kind] and len(arguments) != KINDS[kind]):
            count = KINDS[kind] or "at least one"
            raise ParameterError(f"'{key}': {kind} is {arguments!r}, must have {count} values")
        if kind in (CHOICE, SWEPT):
            return cls(kind, tuple(arguments))
        return cls._of_numbers(key, kind, arguments)

    @classmethod
    def _of_numbers(cls, key: str, kind: str, arguments: list[Any]) -> Distribution:
        if not all(
            isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x)
            for x in arguments
        ):
            raise ParameterError(f"'{key}': {kind} is {arguments!r}, must be finite numbers")
        first, second, *count = arguments
        wanted = {
            "uniform": (first <= second, "least and greatest in order"),
            "log_uniform": (0.0 < first <= second, "positive, least and greatest in order"),
            "normal": (second >= 0.0, "mean and a standard deviation of at least 0"),
            "grid": (bool(count) and isinstance(count[0], int) and count[0] > 0,
                     "first, last and how many"),
        }  # fmt: skip
        right, words = wanted[kind]
        if not right:
            raise ParameterError(f"'{key}': {kind} is {arguments!r}, must be {words}")
        if kind == "grid":
            return cls(SWEPT, tuple(np.linspace(first, second, count[0]).tolist()))
        return cls(kind, (float(first), float(second)))

    @property
    def swept(self) -> bool:
        """Whether each of its values is flown in turn."""
        return self.kind == SWEPT

    @property
    def varies(self) -> bool:
        """Whether flights may differ in it."""
        return self.kind != CONSTANT

    @property
    def ends(self) -> tuple[Any, ...]:
        """Values between which all lie that can be drawn; none where there are no such."""
        return () if self.kind == "normal" else self.arguments

    def draw(self, random: np.random.Generator) -> Any:
        """Draw a value; of one that is swept, the first.

        Args:
            random: Where the numbers come from.
        """
        if self.kind == CHOICE:
            return self.arguments[int(random.integers(len(self.arguments)))]
        if self.kind in (CONSTANT, SWEPT):
            return self.arguments[0]
        first, second = self.arguments
        if self.kind == "uniform":
            return first + (second - first) * float(random.random())
        if self.kind == "normal":
            return first + second * float(random.standard_normal())
        ratio = math.log(second / first)
        return min(first * math.exp(ratio * float(random.random())), second)

    def draw_within(self, random: np.random.Generator, neutral: Any, share: float) -> Any:
        """Draw a value and keep to a share of the way to it from what is without error.

        Of a choice, the value that was drawn is kept with that probability.

        Args:
            random: Where the numbers come from.
            neutral: What is without error.
            share: Of the range [-]: 1 for all of it.
        """
        drawn = self.draw(random)
        if self.kind == CONSTANT or share == 1.0:
            return drawn
        if self.kind == CHOICE:
            return drawn if random.random() < share else neutral
        return neutral + share * (drawn - neutral)
