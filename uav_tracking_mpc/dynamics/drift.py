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

r"""What a drift does to an orbit, in short: how fast it is, how sharp the turn becomes.

The drift c is the wind less the target's velocity: seen from the target the air moves with c. Round
an orbit in it the relative speed changes (:mod:`~uav_tracking_mpc.dynamics.drifting_orbit`); the
turn is sharpest where the tangent is along c.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

# With the drift as fast as the aircraft there is no way back upwind: the share that it may reach.
DRIFT_SHARE = 0.9


def sharpest_turn(radius: Any, level_speed: Any, drift: Any) -> Any:
    """Greatest turn rate round the orbit in [rad/s], (V + |c|)^2 / (d V); numbers and symbols.

    Args:
        radius: d in [m].
        level_speed: V, the horizontal part of the airspeed, in [m/s].
        drift: abs(c), the drift's horizontal strength, in [m/s].
    """
    return (level_speed + drift) ** 2 / (radius * level_speed)


def horizontal(drift: ArrayLike) -> float:
    """Horizontal strength of a drift in [m/s].

    Args:
        drift: c, shape (3,), in [m/s].
    """
    east, north, _ = (float(value) for value in np.asarray(drift, dtype=float))
    return math.hypot(east, north)


def level_speed(airspeed: float, drift: ArrayLike) -> float:
    """Horizontal airspeed that is left beside the vertical drift, V, in [m/s].

    Args:
        airspeed: v in [m/s].
        drift: c, shape (3,), in [m/s].
    """
    vertical = float(np.asarray(drift, dtype=float)[2])
    return math.sqrt(max(0.0, airspeed * airspeed - vertical * vertical))
