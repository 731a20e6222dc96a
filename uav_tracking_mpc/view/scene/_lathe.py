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

"""Meshes: bodies turned on a lathe, and flat plates with some thickness."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Mesh = tuple[NDArray[np.float64], NDArray[np.int64]]  # points (n, 3), triangles (m, 3)


def turned(stations: ArrayLike, sides: int = 12) -> Mesh:
    """A body of revolution about x.

    Args:
        stations: x and radius of each, shape (k, 2), any unit.
        sides: Of its sections.
    """
    along, radius = np.asarray(stations, dtype=float).T
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    points = np.stack(
        [
            np.repeat(along, sides),
            np.outer(radius, np.cos(angle)).ravel(),
            np.outer(radius, np.sin(angle)).ravel(),
        ],
        axis=1,
    )
    here = np.arange(sides)
    there = np.roll(here, -1)
    rings = []
    for k in range(len(along) - 1):
        a, b, c, d = (ring + sides * row for ring, row in
                      ((here, k), (there, k), (here, k + 1), (there, k + 1)))  # fmt: skip
        rings += [np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]
    return points, np.concatenate(rings)


def plate(outline: ArrayLike, thickness: ArrayLike) -> Mesh:
    """A convex flat body.

    Args:
        outline: Its corners in order, shape (k, 3), any unit.
        thickness: From one side to the other, shape (3,), same unit.
    """
    corners, half = np.asarray(outline, dtype=float), 0.5 * np.asarray(thickness, dtype=float)
    count = len(corners)
    fan = np.stack([np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    here = np.arange(count)
    there = np.roll(here, -1)
    edge = np.concatenate(
        [np.stack([here, there, here + count], axis=1),
         np.stack([there, there + count, here + count], axis=1)]
    )  # fmt: skip
    return np.concatenate([corners + half, corners - half]), np.concatenate(
        [fan, fan[:, ::-1] + count, edge]
    )


def joined(*meshes: Mesh) -> Mesh:
    """Several as one.

    Args:
        meshes: Points, shape (n, 3), and triangles, shape (m, 3), of each.
    """
    begins = np.cumsum([0, *(len(points) for points, _ in meshes)])
    return np.concatenate([points for points, _ in meshes]), np.concatenate(
        [faces + begin for (_, faces), begin in zip(meshes, begins, strict=False)]
    )
