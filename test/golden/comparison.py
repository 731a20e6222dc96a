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

"""Compare records of the product's behaviour number by number, with a tolerance for each quantity.

A record is what JSON can hold. The name of a number ends in its unit (``x [m]``, ``range_rms_m``),
and the unit chooses the tolerance, so a new figure needs no entry here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

# Quantity, names, and what may differ between processors: an absolute part in the unit, a share
# of the recorded value, and both where JSBSim flies; README.md beside this file says why.
TOLERANCES = (
    ("time", r"\[s\]$|_s$", (0.06, 0.0), (0.21, 0.0)),  # multiples of the states' period
    ("angle", r"\[rad\]$|_rad$", (1e-8, 0.0), (5e-2, 0.0)),
    ("rate", r"\[rad/s\]$", (1e-7, 0.0), (0.2, 0.0)),
    ("position", r"\[m\]$|_m$", (1e-6, 1e-9), (1.0, 5e-3)),
    ("speed", r"\[m/s\]$|_mps$", (1e-7, 1e-9), (0.15, 5e-3)),
    ("acceleration", r"\[m/s\^2\]$", (1e-7, 0.0), (2.0, 0.0)),
    ("bank rate", r"_dps$", (1e-6, 1e-7), (0.5, 5e-2)),
    ("cost", r"^cost$", (1e-8, 1e-6), (5.0, 0.8)),
    ("figure", r"", (1e-9, 1e-4), (1e-3, 1e-2)),  # proof levels, margins, gains
)
AMPLIFIED = 3.0  # -, times the greatest difference of the twins
# Measured with the wall's clock: only that they are there is compared.
WALL_TIME = re.compile(r"_us$|^solve_time$")
# Equal on the same processor alone: it tells bit for bit from almost.
DIGEST = re.compile(r"digest$")


class Difference(NamedTuple):
    """One place at which two records differ.

    Attributes:
        place: Keys and indices from the outside in.
        recorded: Value in the record; MISSING where it has none.
        found: Value now; MISSING where there is none.
        quantity: Name of the tolerance.
        size: Of the difference over the tolerance; beyond 1 the behaviour is another one.
    """

    place: tuple[str | int, ...]
    recorded: Any
    found: Any
    quantity: str
    size: float

    def __str__(self) -> str:
        parts = list(map(str, self.place))
        if len(parts) > 2 and (every := re.fullmatch(r"every (.+) s", parts[-3])):
            parts[-1] = f"at {float(every[1]) * int(parts[-1]):g} s"
        place = "/".join(parts)
        words = f"{place}: recorded {self.recorded!r}, now {self.found!r}"
        if not _is_number(self.recorded) or not _is_number(self.found):
            return words
        change = abs(self.found - self.recorded)
        return f"{words} (by {change:.3g}, {self.size:.2g} of the tolerance of a {self.quantity})"


class _Missing:
    def __repr__(self) -> str:
        return "nothing"


MISSING = _Missing()


def differences(
    recorded: Any, found: Any, place: tuple[str | int, ...] = ()
) -> Iterator[Difference]:
    """Every place at which two records differ, be it in the last bit.

    Args:
        recorded: The record: dicts, lists, numbers, texts, truths and None.
        found: The same, now.
        place: Where in a record they stand.
    """
    if isinstance(recorded, dict) and isinstance(found, dict):
        for key in [*recorded, *(key for key in found if key not in recorded)]:
            pair = recorded.get(key, MISSING), found.get(key, MISSING)
            yield from differences(*pair, (*place, key))
    elif isinstance(recorded, list) and isinstance(found, list):
        for index in range(max(len(recorded), len(found))):
            pair = (each[index] if index < len(each) else MISSING for each in (recorded, found))
            yield from differences(*pair, (*place, index))
    elif recorded != found or isinstance(recorded, bool) != isinstance(found, bool):
        if _is_number(recorded) and _is_number(found) and WALL_TIME.search(_name(place)):
            return
        yield Difference(place, recorded, found, *_size(recorded, found, place))


def amplified(beyond: Sequence[Difference], found: Any, twins: Sequence[Any]) -> list[Difference]:
    """Of the differences those that the least other begin of the same flight does not explain.

    A flight that amplifies the last bit is another one on each processor. What its twins differ by
    among themselves, by name of the value, says how far; a few of them show a third of it at least.

    Args:
        beyond: Differences beyond their tolerance.
        found: The record now.
        twins: The same from beside.
    """
    explained: dict[str, float] = {}
    for twin in twins:
        for each in differences(found, twin):
            name = _name(each.place)
            explained[name] = max(explained.get(name, 0.0), each.size)
    return [
        each for each in beyond if each.size > AMPLIFIED * explained.get(_name(each.place), 0.0)
    ]


def _name(place: tuple[str | int, ...]) -> str:
    return next((part for part in reversed(place) if isinstance(part, str)), "")


def _size(recorded: Any, found: Any, place: tuple[str | int, ...]) -> tuple[str, float]:
    """Quantity, and difference over tolerance: infinite for what is no number."""
    name, jsbsim = _name(place), "jsbsim" in str(place[:1])
    if DIGEST.search(name) and isinstance(recorded, str) and isinstance(found, str):
        return "digest", 0.0
    numbers = _is_number(recorded) and _is_number(found)
    if not numbers or (isinstance(recorded, int) and isinstance(found, int)):
        return "value", math.inf
    quantity, _, *parts = next(row for row in TOLERANCES if re.search(row[1], name))
    absolute, share = parts[jsbsim]
    change = abs(found - recorded)
    if quantity == "angle":
        change = abs(math.remainder(change, 2.0 * math.pi))
    size = change / (absolute + share * abs(recorded))
    return quantity, math.inf if math.isnan(size) else size


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
