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

"""Which way round: the nearer direction, kept once chosen."""

from __future__ import annotations

import math

from uav_tracking_mpc.dynamics.orbit import CLOCKWISE, COUNTER_CLOCKWISE
from uav_tracking_mpc.estimation.situation import Situation

# The other direction is the nearer one beyond 90 deg from the tangent. The direction changes only
# when it is nearer by more than 45 deg (hysteresis).
HYSTERESIS = math.radians(45.0)


def nearest_direction(
    situation: Situation, present: str | None = None, stands: bool = False
) -> str:
    """Direction of the orbit to which the relative velocity needs to turn less.

    Args:
        situation: Where the aircraft is and goes.
        present: Direction that is flown, if one is: kept but for a flight clearly against it.
        stands: Whether it is kept in any case.
    """
    x, y, _ = situation.offset.tolist()
    w_x, w_y, _ = situation.relative_velocity.tolist()
    speed_distance = math.hypot(x, y) * math.hypot(w_x, w_y)
    # Cosine of the angle between relative velocity and counter-clockwise tangent.
    along = (x * w_y - y * w_x) / speed_distance if speed_distance > 0.0 else 0.0
    if present is None:
        return COUNTER_CLOCKWISE if along > 0.0 else CLOCKWISE
    follows = along if present == COUNTER_CLOCKWISE else -along
    if stands or not follows < -math.sin(HYSTERESIS):  # also where it is no number
        return present
    return CLOCKWISE if present == COUNTER_CLOCKWISE else COUNTER_CLOCKWISE
