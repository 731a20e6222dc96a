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
