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

r"""Latitude, longitude and altitude to the axes of ``map`` about a stated origin, and back.

The ellipsoid is WGS 84 (NIMA TR8350.2, Table 3.1). ``map`` is the tangent plane at the origin:
East, North, Up in true metres. Autopilots have local coordinates of their own on a sphere
(ArduPilot of 6378.1 km, PX4 of 6371 km), in which a circle of 300 m is up to 1 m out of round; what
they tell in latitude and longitude is free of that.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

SEMI_MAJOR_AXIS = 6378137.0  # m, WGS 84
FLATTENING = 1.0 / 298.257223563  # -, WGS 84
ECCENTRICITY_SQUARED = FLATTENING * (2.0 - FLATTENING)  # -, WGS 84
_ITERATIONS = 5  # iterations of the altitude's fixed point: it gains a factor of 150 in each


class LocalFrame:
    """The axes of ``map`` at a place on the earth.

    Args:
        latitude: Of the origin in [rad], positive North.
        longitude: Of the origin in [rad], positive East.
        altitude: Of the origin in [m]; above sea level or above the ellipsoid, as all others are.

    Attributes:
        latitude: As above.
        longitude: As above.
        altitude: As above.

    Raises:
        ValueError: Not finite, or no latitude.
    """

    def __init__(self, latitude: float, longitude: float, altitude: float) -> None:
        if not math.isfinite(latitude + longitude + altitude) or abs(latitude) > 0.5 * math.pi:
            raise ValueError(
                f"origin is latitude {math.degrees(latitude)} deg, longitude "
                f"{math.degrees(longitude)} deg, altitude {altitude} m, must be finite and within "
                "90 deg of the equator"
            )
        self.latitude, self.longitude, self.altitude = latitude, longitude, altitude
        sin_lat, cos_lat = math.sin(latitude), math.cos(latitude)
        sin_lon, cos_lon = math.sin(longitude), math.cos(longitude)
        self._axes = np.array(  # East, North, Up in the axes of the earth
            [
                [-sin_lon, cos_lon, 0.0],
                [-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat],
                [cos_lat * cos_lon, cos_lat * sin_lon, sin_lat],
            ]
        )
        self._origin = _earth_centred(latitude, longitude, altitude)

    def position(self, latitude: float, longitude: float, altitude: float) -> NDArray[np.float64]:
        """Position in ``map``, shape (3,), in [m].

        Args:
            latitude: In [rad].
            longitude: In [rad].
            altitude: In [m], above what the origin's is.
        """
        return self._axes @ (_earth_centred(latitude, longitude, altitude) - self._origin)

    def place(self, position: ArrayLike) -> tuple[float, float, float]:
        """Latitude and longitude in [rad] and altitude in [m] of a position.

        Args:
            position: In ``map``, shape (3,), in [m].
        """
        x, y, z = self._origin + self._axes.T @ np.asarray(position, dtype=float)
        horizontal = math.hypot(x, y)
        latitude = math.atan2(z, horizontal * (1.0 - ECCENTRICITY_SQUARED))
        altitude = 0.0
        for _ in range(_ITERATIONS):
            radius = _prime_vertical(latitude)
            # Unlike horizontal / cos(latitude) this is well conditioned at the poles too.
            altitude = (
                horizontal * math.cos(latitude)
                + z * math.sin(latitude)
                - radius * (1.0 - ECCENTRICITY_SQUARED * math.sin(latitude) ** 2)
            )
            share = ECCENTRICITY_SQUARED * radius / (radius + altitude)
            latitude = math.atan2(z, horizontal * (1.0 - share))
        return latitude, math.atan2(y, x), altitude


def _prime_vertical(latitude: float) -> float:
    """Radius of curvature across the meridian in [m]."""
    return SEMI_MAJOR_AXIS / math.sqrt(1.0 - ECCENTRICITY_SQUARED * math.sin(latitude) ** 2)


def _earth_centred(latitude: float, longitude: float, altitude: float) -> NDArray[np.float64]:
    """Position in the axes of the earth, shape (3,), in [m]."""
    radius = _prime_vertical(latitude)
    across = (radius + altitude) * math.cos(latitude)
    return np.array(
        [
            across * math.cos(longitude),
            across * math.sin(longitude),
            (radius * (1.0 - ECCENTRICITY_SQUARED) + altitude) * math.sin(latitude),
        ]
    )
