"""What an extension must keep, said in words where it does not."""

from __future__ import annotations

from typing import Any

import numpy as np


class ConformanceError(AssertionError):
    """An extension does not keep what its base asks for; the message says what and where."""


def require(holds: bool, words: str) -> None:
    """Stop a check where something does not hold.

    Args:
        holds: Whether it does.
        words: What is wrong if not.

    Raises:
        ConformanceError: It does not hold.
    """
    if not holds:
        raise ConformanceError(words)


def require_array(value: Any, shape: tuple[int, ...], largest: float, words: str) -> None:
    """Stop a check where a value is not an array of finite numbers of a plausible size.

    Args:
        value: To be checked.
        shape: That it must have.
        largest: Greatest plausible magnitude, in the [unit] of the value.
        words: What the value is.

    Raises:
        ConformanceError: It is not.
    """
    array = np.asarray(value)
    require(array.shape == shape, f"{words} has shape {array.shape}, must have {shape}")
    require(np.issubdtype(array.dtype, np.floating), f"{words} holds {array.dtype}, not floats")
    require(bool(np.all(np.isfinite(array))), f"{words} is {array.tolist()}, must be finite")
    require(
        bool(np.all(np.abs(array) <= largest)),
        f"{words} is {array.tolist()}, beyond {largest:g}: are the units right?",
    )


def require_name(extension: type) -> str:
    """The name of an extension.

    Args:
        extension: Class that a user wrote.

    Raises:
        ConformanceError: It has none.
    """
    name = getattr(extension, "name", None)
    require(isinstance(name, str) and name != "", f"{extension.__name__} has no `name`")
    return str(name)
