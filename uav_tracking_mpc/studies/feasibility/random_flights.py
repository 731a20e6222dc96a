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

"""Random states that an aircraft can be in: anywhere about the target, with and without drift."""

from __future__ import annotations

import math

import numpy as np

from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.settings.tracking import TrackingParameters

NEAREST, FARTHEST = 0.2, 3.3  # r_d
LOWEST, HIGHEST = -0.3, 0.45  # r_d from z_d
STEEPEST = 0.95  # |z| / r
DRIFT_SHARE = 0.4  # of the airspeed, the strongest drift
STILL_SHARE = 0.3  # of the states, without drift


def random_situations(parameters: TrackingParameters, count: int, seed: int = 0) -> list[Situation]:
    """Situations inside the envelope: any heading, any turn, no climb under way.

    Args:
        parameters: Orbit and limits.
        count: How many.
        seed: Of the generator.
    """
    generator = np.random.default_rng(seed)
    return [_random_situation(parameters, generator) for _ in range(count)]


def _random_situation(p: TrackingParameters, generator: np.random.Generator) -> Situation:
    distance = generator.uniform(max(NEAREST * p.range, p.distance_min), FARTHEST * p.range)
    lowest = max(p.altitude + LOWEST * p.range, p.height_min)
    height = generator.uniform(lowest, max(lowest, p.altitude + HIGHEST * p.range))
    height = min(max(height, -STEEPEST * distance), STEEPEST * distance)
    level = math.sqrt(distance**2 - height**2)
    azimuth, heading, blowing = generator.uniform(-math.pi, math.pi, 3)
    airspeed = generator.uniform(p.airspeed_min, p.airspeed_max)
    path_angle = generator.uniform(p.path_angle_min, p.path_angle_max)
    turning = p.envelope.turn_rate_max(airspeed)
    drift = generator.uniform(0.0, DRIFT_SHARE) * min(airspeed, p.airspeed)
    if generator.random() < STILL_SHARE:
        drift = 0.0
    return Situation(
        vehicle=np.array(
            [
                level * math.cos(azimuth),
                level * math.sin(azimuth),
                height,
                heading,
                path_angle,
                airspeed,
            ]
        ),
        target=np.zeros(3),
        drift=drift * np.array([math.cos(blowing), math.sin(blowing), 0.0]),
        drift_rate=np.zeros(3),
        rates=np.array([generator.uniform(-turning, turning), 0.0, 0.0]),
    )
