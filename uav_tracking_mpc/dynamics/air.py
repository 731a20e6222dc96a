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

"""Gravity, the standard atmosphere, and the strengths and lengths of Dryden gusts."""

from __future__ import annotations

import math
from typing import NamedTuple

GRAVITY = 9.80665  # m/s^2, standard gravity: 3rd General Conference on Weights and Measures, 1901


SEA_LEVEL_TEMPERATURE = 288.15  # K, of the standard atmosphere
LAPSE_RATE = 0.0065  # K/m, of the standard atmosphere
GAS_CONSTANT = 287.05287  # J/(kg K), of dry air
HIGHEST, LOWEST = 11000.0, -5000.0  # m, of the troposphere


def density_ratio(altitude: float) -> float:
    """Density of the air over that at sea level [-].

    Args:
        altitude: Above sea level in [m]; what lies outside of the troposphere counts as its edge.
    """
    height = min(max(altitude, LOWEST), HIGHEST)
    temperature_ratio = 1.0 - LAPSE_RATE * height / SEA_LEVEL_TEMPERATURE
    return float(temperature_ratio ** (GRAVITY / (GAS_CONSTANT * LAPSE_RATE) - 1.0))


def true_over_equivalent(altitude: float) -> float:
    """True airspeed over equivalent airspeed, 1 / sqrt(density ratio) [-].

    Args:
        altitude: Above sea level in [m].
    """
    return 1.0 / math.sqrt(density_ratio(altitude))


FOOT = 0.3048  # m, the international foot
HEIGHTS = (10.0 * FOOT, 1000.0 * FOOT)  # m, where the model holds; beyond, its value there


class GustScales(NamedTuple):
    """Strengths and lengths of gusts.

    Attributes:
        level: sigma_u = sigma_v in [m/s].
        vertical: sigma_w in [m/s].
        long: L_u = L_v in [m].
        short: L_w in [m].
    """

    level: float
    vertical: float
    long: float
    short: float


def gust_scales(height: float, intensity: float) -> GustScales:
    """Strengths and lengths of gusts at a height; outside the model's, its value at the end.

    Args:
        height: Above ground in [m].
        intensity: W20 in [m/s].
    """
    lowest, highest = HEIGHTS
    height = min(max(height, lowest), highest)
    shape = 0.177 + 0.000823 * height / FOOT
    vertical = 0.1 * intensity
    return GustScales(vertical / shape**0.4, vertical, height / shape**1.2, height)
