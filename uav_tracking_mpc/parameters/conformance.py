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

"""What an extension must keep, said in words where it does not."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np


class ConformanceError(AssertionError):
    """An extension does not keep what its base asks for; the message says what and where."""


@contextmanager
def judged(name: str) -> Iterator[None]:
    """Let a check end by its own errors alone: whatever else it raises, its author wants to know.

    Args:
        name: Of the extension that is checked.

    Raises:
        ConformanceError: The check has raised something.
    """
    try:
        yield
    except ConformanceError:
        raise
    except Exception as error:
        raise ConformanceError(f"{name}: {type(error).__name__}: {error}") from error


def require(holds: object, words: str) -> None:
    """Stop a check where something does not hold.

    Args:
        holds: Whether it does.
        words: What is wrong if not.

    Raises:
        ConformanceError: It does not hold.
    """
    if not holds:
        raise ConformanceError(words)


def require_vector(value: Any, largest: float, words: str) -> None:
    """Stop a check where a value is not a vector of three finite numbers of a plausible size.

    Args:
        value: To be checked.
        largest: Greatest plausible magnitude, in the [unit] of the value.
        words: What the value is.

    Raises:
        ConformanceError: It is not.
    """
    vector = np.asarray(value, dtype=float)
    require(vector.shape == (3,), f"{words} has shape {vector.shape}, must have (3,)")
    require(np.isfinite(vector).all(), f"{words} is {vector.tolist()}, must be finite")
    size = float(np.linalg.norm(vector))
    require(size <= largest, f"{words} is {vector.tolist()}: are the units right?")


def require_name(extension: type) -> str:
    """The name of an extension.

    Args:
        extension: Class that a user wrote.

    Raises:
        ConformanceError: It has none.
    """
    name = getattr(extension, "name", None)
    require(isinstance(name, str) and name, f"{extension.__name__} has no `name`")
    return str(name)
