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

"""The standard atmosphere (ICAO Doc 7488, U.S. Standard Atmosphere 1976), up to 11 km."""

from __future__ import annotations

import math

from uav_tracking_mpc.dynamics.gravity import GRAVITY

SEA_LEVEL_TEMPERATURE = 288.15  # K
LAPSE_RATE = 0.0065  # K/m
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
