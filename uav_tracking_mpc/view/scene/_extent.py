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

"""How large a flight is, from which everything that is drawn takes its size, and where it is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.view.sight import Sight
from uav_tracking_mpc.view.watched_flight import WatchedFlight

UNKNOWN = 100.0  # m
SMALLEST, LARGEST = 1.0, 1e5  # m


def extent(flight: WatchedFlight, sight: Sight) -> float:
    """Radius of the wanted orbit, else its range, in [m].

    Args:
        flight: What is flown.
        sight: What there is to see of it.
    """
    size = UNKNOWN
    if sight.wanted is not None:
        size = abs(sight.wanted.radius)
    elif flight.tracking is not None:
        size = flight.tracking.range
    return min(max(size, SMALLEST), LARGEST) if math.isfinite(size) else UNKNOWN


def centre(sight: Sight) -> NDArray[np.float64]:
    """Centre of the wanted orbit, else the aircraft, in ``map``, shape (3,), in [m].

    Args:
        sight: What there is to see.
    """
    if sight.wanted is not None and finite(sight.wanted.centre):
        return sight.wanted.centre
    return sight.position


def ground_height(sight: Sight) -> float:
    """Height of the target in ``map``, else 0, in [m].

    Args:
        sight: What there is to see.
    """
    if sight.target is None or not finite(sight.target.position):
        return 0.0
    return float(sight.target.position[2])


def finite(*values: Any) -> bool:
    """Whether all values can be drawn.

    Args:
        values: Numbers or arrays of any shape.
    """
    return all(bool(np.isfinite(value).all()) for value in values)
