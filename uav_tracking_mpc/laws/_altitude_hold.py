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

"""Height above the target and airspeed: the loops that the classical loiter laws share."""

from __future__ import annotations

import math

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.limits._envelope import Envelope

CLIMB_GAIN = 0.45  # 1/s, climb rate asked for per height error
PATH_ANGLE_GAIN = 1.5  # 1/s
SPEED_GAIN = 0.8  # 1/s


def altitude_hold(orbit: Orbit, envelope: Envelope, situation: Situation) -> tuple[float, float]:
    r"""Path-angle rate and acceleration that lead to the orbit's height and airspeed.

    The height error asks for a climb rate relative to the target, that for a path angle,

    .. math:: v \sin\chi_{des} + c_z = k_z (z_d - z)

    kept to those at which the airspeed can be held. The gains come from a grid of height steps of
    10 to 60 m at 22 m/s, with inner loops of 0.13 s lag and 0.2 s dead time: least integrated
    error without overshoot, and with about 5 % of it when the inner loops are twice as slow.

    Args:
        orbit: Height above the target and airspeed to hold.
        envelope: Limits of the path angle, and the least height, which comes before the orbit's.
        situation: Aircraft and target.

    Returns:
        (u_chi, u_v) in [rad/s, m/s^2], not yet clipped.
    """
    _, _, height, _, path_angle, speed = situation.vehicle.tolist()
    _, _, drift = situation.drift.tolist()
    _, _, ground = situation.target.tolist()
    wanted = ground + orbit.altitude
    # At the floor the target is not followed down, and of the vertical drift only that which may
    # be a sinking air counts.
    climb = max(
        CLIMB_GAIN * (wanted - height) - drift,
        CLIMB_GAIN * (envelope.height_min - height) - min(drift, 0.0),
    )
    lower, upper = envelope.path_angle_limits(speed)
    sine = climb / max(speed, 0.1 * orbit.speed)
    wanted_angle = math.asin(min(max(sine, math.sin(lower)), math.sin(upper)))
    return PATH_ANGLE_GAIN * (wanted_angle - path_angle), SPEED_GAIN * (orbit.speed - speed)
