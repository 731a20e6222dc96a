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

"""Circles of radius 1 in the horizontal plane, as line segments."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SEGMENTS = 96


def ring(dashes: int = 0) -> NDArray[np.float64]:
    """A circle.

    Args:
        dashes: It is broken into so many; whole by default.

    Returns:
        Shape (n, 2, 3).
    """
    angle = np.linspace(0.0, 2.0 * np.pi, SEGMENTS + 1)
    circle = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    segments = np.stack([circle[:-1], circle[1:]], axis=1)
    if not dashes:
        return segments
    each = SEGMENTS // dashes
    return segments[np.arange(SEGMENTS) % each < 0.5 * each]


def chevrons(count: int) -> NDArray[np.float64]:
    """Arrow heads on the circle that point counter-clockwise.

    Args:
        count: How many.

    Returns:
        Shape (2 * count, 2, 3).
    """
    heads = []
    for angle in 2.0 * np.pi * np.arange(count) / count:
        tip = np.array([np.cos(angle), np.sin(angle), 0.0])
        for radius in (0.97, 1.03):
            behind = radius * np.array([np.cos(angle - 0.06), np.sin(angle - 0.06), 0.0])
            heads.append([behind, tip])
    return np.array(heads)
