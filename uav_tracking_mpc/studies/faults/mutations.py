"""What a sender gone wrong makes of a message: one field, anywhere in it, is changed."""

from __future__ import annotations

import math
import random
from typing import Any

NUMBERS = (
    math.nan, math.inf, -math.inf, 1e300, -1e300, 1.7e308, 5e-324, -1e-310, -0.0, 0.0, 1.0, -1.0,
    9.99e6, -9.99e6, 1.01e7, 999.0, -1001.0, 1e-9,
)  # fmt: skip
FACTORS = (-1.0, 1e-3, 0.5, 1.0005, 1.1, 2.0, 1e3)
TEXTS = ("", " map", "MAP", "odom", "map", "base_link", "earth\n", "m\u00e4p", "map" * 1000)
EXTREMES = {"int32": (-(2**31), 2**31 - 1), "uint32": (0, 2**32 - 1)}
INTEGERS = (0, 1, -1, 999_999_999, 1_000_000_000, 1_000_000_001)


def mutate(message: Any, rng: random.Random) -> None:
    """Change one field of a ROS message in place, found by descending at random.

    Whatever comes out could have come over the wire: types are kept, values are not.

    Args:
        message: Any ROS message.
        rng: For every choice.
    """
    kinds = message.get_fields_and_field_types()
    name = rng.choice(list(kinds))
    value = getattr(message, name)
    if isinstance(value, float):
        setattr(message, name, _number(value, rng))
    elif isinstance(value, int):
        setattr(message, name, _integer(value, kinds[name], rng))
    elif isinstance(value, str):
        setattr(message, name, rng.choice(TEXTS))
    elif isinstance(value, list):
        if value and hasattr(value[0], "get_fields_and_field_types") and rng.random() < 0.6:
            mutate(rng.choice(value), rng)
        else:
            setattr(message, name, _sequence(value, rng))
    elif hasattr(value, "get_fields_and_field_types"):
        mutate(value, rng)
    else:  # an array of numbers, such as a covariance
        value[rng.randrange(len(value))] = rng.choice(NUMBERS)


def _number(value: float, rng: random.Random) -> float:
    if rng.random() < 0.6:
        return rng.choice(NUMBERS)
    return value * rng.choice(FACTORS)


def _integer(value: int, kind: str, rng: random.Random) -> int:
    lowest, highest = EXTREMES[kind]
    candidate = rng.choice((lowest, highest, *INTEGERS, value + rng.choice(INTEGERS)))
    return min(max(candidate, lowest), highest)


def _sequence(value: list[Any], rng: random.Random) -> list[Any]:
    """Shorter, longer or in another order; what it holds stays."""
    changed = list(value)
    if not changed or rng.random() < 0.2:
        return []
    first, second = rng.randrange(len(changed)), rng.randrange(len(changed))
    choice = rng.randrange(3)
    if choice == 0:
        del changed[first:]
    elif choice == 1:
        changed.insert(first, changed[second])
    else:
        changed[first], changed[second] = changed[second], changed[first]
    return changed


def extreme_stamp(stamp: Any, rng: random.Random) -> None:
    """First or last of all times, and what only looks like a time: a second of 4.29e9 ns."""
    stamp.sec = rng.choice(EXTREMES["int32"])
    stamp.nanosec = rng.choice((0, 999_999_999, EXTREMES["uint32"][1] - rng.randrange(10**8)))


def scale_quaternion(orientation: Any, rng: random.Random) -> None:
    """No unit quaternion any more, or hardly one, or the same attitude with the other sign."""
    factor = rng.choice((0.0, -1.0, 1e-200, 0.5, 0.9995, 1.0005, 1.002, 1e160, math.nan))
    for axis in "xyzw":
        setattr(orientation, axis, getattr(orientation, axis) * factor)
