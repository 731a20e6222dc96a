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

"""The orbit that is flown, by numbers: what an autopilot needs to hold it, or to loiter about it.

An autopilot that holds altitude and airspeed itself is told both. One that hears nothing more from
the controller can go on around the centre, which moves with the target.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit


class FlownOrbit(NamedTuple):
    """A horizontal circle in ``map`` at one time, and how its centre moves.

    Attributes:
        centre: East, north and up in ``map``, shape (3,), in [m]; up is that of the circle itself.
        velocity: Of the centre in ``map``, shape (3,), in [m/s].
        radius: Horizontal, in [m]: positive counter-clockwise, negative clockwise, seen from above.
        airspeed: To hold in [m/s].
    """

    centre: NDArray[np.float64]
    velocity: NDArray[np.float64]
    radius: float
    airspeed: float


def orbit_about(
    target: ArrayLike,
    velocity: ArrayLike,
    orbit: Orbit,
    shape: tuple[float, float, float] | None = None,
) -> FlownOrbit:
    """The orbit about a target.

    Args:
        target: Position in ``map``, shape (3,), in [m].
        velocity: Of the target in ``map``, shape (3,), in [m/s].
        orbit: What is wanted; its direction counts in any case.
        shape: Range [m], altitude above the target [m] and airspeed [m/s] that are flown in the
            place of the wanted ones.
    """
    if shape is None:
        shape = orbit.range, orbit.altitude, orbit.speed
    range_, altitude, airspeed = shape
    radius = math.sqrt(max(range_**2 - altitude**2, 0.0))
    return FlownOrbit(
        centre=np.asarray(target, dtype=float) + np.array([0.0, 0.0, altitude]),
        velocity=np.array(velocity, dtype=float),
        radius=radius if orbit.direction == COUNTER_CLOCKWISE else -radius,
        airspeed=airspeed,
    )
