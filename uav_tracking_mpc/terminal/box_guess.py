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

"""Good guesses for the test of a box, in plain floating point: nothing here has to be right.

The bound q of ``box_check`` has free numbers: Young's t, the multiplier m, the diagonal D and a
point of tangency. Any choice is sound; these make q small.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

_MULTIPLIER_STEPS = 14


class Guess:
    """Numbers t, m, D and a point of tangency that make q small on a box.

    Args:
        p: P, shape (5, 5).
        right: N, shape (5, 5).
        level: varrho [-].
        center: c, shape (5,).
        half: h, shape (5,).
        value: a, shape (5,).
        jacobian: J, shape (5, 5).
        error: E^2 [-].
        multiplier: First guess of m [-].
    """

    def __init__(
        self,
        p: NDArray[np.float64],
        right: NDArray[np.float64],
        level: float,
        center: NDArray[np.float64],
        half: NDArray[np.float64],
        value: NDArray[np.float64],
        jacobian: NDArray[np.float64],
        error: float,
        multiplier: float,
    ) -> None:
        pj = p @ jacobian
        jpj, jpa = jacobian.T @ pj, pj.T @ value
        norm = float(value @ p @ value)
        self.excess, self.young, self.multiplier, self.reach = np.inf, 1.0, 0.0, 1.0
        self.convexifier, self.point = np.zeros(len(center)), np.zeros(len(center))
        tau = min(max(1e-9, np.sqrt(error / max(norm, 1e-300))), 1.0)
        point = np.zeros(len(center))
        low, high = 0.0, np.inf
        for attempt in range(_MULTIPLIER_STEPS):
            weight = right + multiplier * p
            for _ in range(2 if attempt == 0 else 1):  # t hardly depends on m
                curved = weight - (1.0 + tau) * jpj
                bend = _convexifier(curved, half)
                linear = (1.0 + tau) * jpa - weight @ center
                point = _maximise(curved + np.diag(bend), linear, half, point)
                image = value + jacobian @ point
                reach = float(np.sqrt(max(image @ p @ image, 1e-300)))
                used, tau = tau, min(max(1e-9, np.sqrt(error) / reach), 1.0)
            x = center + point
            height = float(x @ p @ x)
            excess = (
                (1.0 + used) * reach**2
                + (1.0 + 1.0 / used) * error
                - float(x @ weight @ x)
                + multiplier * level
                + float(bend @ (half**2 - point**2))
            )
            if excess < self.excess:
                self.excess, self.young, self.multiplier = excess, used, multiplier
                self.convexifier, self.reach, self.point = bend, reach, point
            if excess < -1e-12 * (reach**2 + height):
                break
            # The bound is convex in m with slope varrho - |x|_P^2 at the worst point: follow it.
            if abs(height - level) < 1e-4 * level:
                break
            if height > level:
                low = multiplier
                if not np.isfinite(high):
                    multiplier = max(0.03, 4.0 * multiplier)
                    if multiplier > 1e3:
                        break
                    continue
            elif multiplier == 0.0:
                break  # the worst point lies inside X_f: the multiplier cannot help
            else:
                high = multiplier
            if (high - low) * abs(height - level) < excess:
                break  # nothing within the bracket can bring it below 0
            multiplier = 0.5 * (low + high)
        self.multiplier = float(f"{self.multiplier:.6g}")  # the certificate carries it


def _convexifier(curved: NDArray[np.float64], half: NDArray[np.float64]) -> NDArray[np.float64]:
    """Diagonal D that makes ``curved`` + D positive definite, small in sum D_ii h_i^2."""
    scaled = curved * np.outer(half, half)
    values, vectors = np.linalg.eigh(scaled)
    floor = 1e-7 * abs(values[-1])
    if values[0] > floor:
        return np.zeros(len(half))
    bend = np.zeros(len(half))
    for value, vector in zip(values, vectors.T, strict=True):
        if value <= floor:
            size = np.abs(vector)
            bend += (floor - value) * size * size.sum()
    return (bend * 1.001 + floor) / half**2


def _maximise(
    curved: NDArray[np.float64],
    linear: NDArray[np.float64],
    half: NDArray[np.float64],
    start: NDArray[np.float64],
) -> Any:
    """Maximise 2 l'd - d'Sd over |d_i| <= h_i: coordinate ascent after a Newton step."""
    n = len(half)
    try:
        newton = np.linalg.solve(curved, linear)
    except np.linalg.LinAlgError:
        newton = start
    if np.all(np.abs(newton) <= half):
        return newton
    rows, target, h = curved.tolist(), linear.tolist(), half.tolist()
    d = np.clip(newton, -half, half).tolist()
    for _ in range(8):
        for _ in range(2):
            for i in range(n):
                row = rows[i]
                rest = target[i] + row[i] * d[i]
                for entry, value in zip(row, d, strict=True):
                    rest -= entry * value
                d[i] = min(max(rest / row[i], -h[i]), h[i])
        point = np.array(d)
        free = np.abs(point) < half
        if free.any():  # Newton step among the coordinates that are not at a bound
            fixed = linear[free] - curved[np.ix_(free, ~free)] @ point[~free]
            step = np.linalg.solve(curved[np.ix_(free, free)], fixed)
            inside = bool(np.all(np.abs(step) <= half[free]))
            point[free] = np.clip(step, -half[free], half[free])
        else:
            inside = True
        slope = linear - curved @ point
        if inside and np.all(slope[~free] * point[~free] >= 0.0):
            break
        d = point.tolist()
    return point
