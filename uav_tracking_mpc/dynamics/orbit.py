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

"""The orbit to fly: a horizontal circle about the target."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

CLOCKWISE = "clockwise"
COUNTER_CLOCKWISE = "counter_clockwise"
DIRECTIONS = (CLOCKWISE, COUNTER_CLOCKWISE)


@dataclass(frozen=True)
class Orbit:
    """Reference (r_d, z_d, v_d) and direction of the steady turn (Section 3.1, Table 1).

    Attributes:
        range: r_d, distance to the target in [m], greater than ``abs(altitude)``.
        altitude: z_d, height above the target in [m].
        speed: v_d in [m/s], positive.
        direction: ``clockwise`` (theta = +pi/2, u_psi < 0) or ``counter_clockwise``
            (theta = -pi/2, u_psi > 0), seen from above.

    Raises:
        ValueError: A value is not finite or outside the ranges above.
    """

    range: float
    altitude: float
    speed: float
    direction: str = CLOCKWISE

    def __post_init__(self) -> None:
        """Refuse an orbit that is no circle."""
        if not math.isfinite(self.altitude):
            raise ValueError(f"orbit altitude is {self.altitude} m, must be finite")
        if not (math.isfinite(self.range) and self.range > abs(self.altitude)):
            raise ValueError(
                f"orbit range is {self.range} m, must be finite and greater than "
                f"|altitude| = {abs(self.altitude)} m"
            )
        if not (math.isfinite(self.speed) and self.speed > 0.0):
            raise ValueError(f"orbit speed is {self.speed} m/s, must be finite and positive")
        if self.direction not in DIRECTIONS:
            raise ValueError(
                f"orbit direction is {self.direction!r}, must be one of {', '.join(DIRECTIONS)}"
            )

    @property
    def in_short(self) -> str:
        """The numbers in words."""
        return f"{self.range:g} m at {self.altitude:g} m and {self.speed:g} m/s"

    @property
    def radius(self) -> float:
        """Horizontal distance d_d = sqrt(r_d^2 - z_d^2) to the target in [m]."""
        return math.sqrt(self.range**2 - self.altitude**2)

    @property
    def bearing(self) -> float:
        """Steady bearing theta_ss in [rad]: +pi/2 clockwise, -pi/2 counter-clockwise."""
        return math.pi / 2.0 if self.direction == CLOCKWISE else -math.pi / 2.0

    @property
    def steady_state(self) -> NDArray[np.float64]:
        """x_ss = (r_d, theta_ss, z_d, 0, v_d), shape (5,), in [m, rad, m, rad, m/s]."""
        return np.array([self.range, self.bearing, self.altitude, 0.0, self.speed])
