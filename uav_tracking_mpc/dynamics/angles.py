"""Angles live on a circle: wrap them where they enter and where they are subtracted."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def wrap_angle(angle: ArrayLike) -> NDArray[np.float64]:
    """Wrap angles to (-pi, pi].

    Angles that already lie there come back bit for bit.

    Args:
        angle: Angle or array of angles in [rad], any shape.

    Returns:
        The same shape (0-d for a scalar), in [rad].
    """
    angle = np.asarray(angle, dtype=float)
    wrapped = np.pi - np.mod(np.pi - angle, 2.0 * np.pi)
    return np.where((angle > -np.pi) & (angle <= np.pi), angle, wrapped)


def angle_difference(minuend: ArrayLike, subtrahend: ArrayLike) -> NDArray[np.float64]:
    """Shortest signed turn from ``subtrahend`` to ``minuend``, in (-pi, pi].

    Args:
        minuend: Angle or angles in [rad], any shape.
        subtrahend: Angle or angles in [rad], of a shape that broadcasts with the other.

    Returns:
        Of the broadcast shape, in [rad].
    """
    return wrap_angle(np.asarray(minuend, dtype=float) - np.asarray(subtrahend, dtype=float))
