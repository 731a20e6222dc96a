"""The airspeed that belongs to a measurement; without one the air is taken as still."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.estimation.measurement import Measurement, MeasurementError

SLOW = 0.1  # m/s over ground, below which the body's axis tells where the vehicle goes


class AirData:
    """The newest airspeed that came by itself, beside the measurements of the aircraft.

    Args:
        timeout: Greatest difference of its stamp from that of a measurement in [s].

    Attributes:
        missing: Whether the latest vehicle state had no airspeed to go by.
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.reset()

    def reset(self) -> None:
        """Forget the airspeed."""
        self._stamp, self._airspeed = -math.inf, math.nan
        self.missing = False

    def see(self, stamp: float, airspeed: float) -> None:
        """Take in a measured airspeed.

        Args:
            stamp: When it was measured in [s].
            airspeed: In [m/s].

        Raises:
            MeasurementError: One of them is not finite, or the airspeed is negative.
        """
        if not (math.isfinite(stamp) and math.isfinite(airspeed) and airspeed >= 0.0):
            raise MeasurementError(
                f"airspeed is {airspeed!r} m/s at {stamp!r} s, must be finite and at least 0 m/s"
            )
        self._stamp, self._airspeed = stamp, airspeed

    def vehicle_state(self, measurement: Measurement) -> NDArray[np.float64]:
        """State (x, y, z, psi, chi, v) of position and air velocity, shape (6,).

        In still air the velocity over ground is that through the air.

        Args:
            measurement: Its own airspeed counts first, then the one that came by itself.
        """
        airspeed = measurement.airspeed
        if airspeed is None and abs(measurement.stamp - self._stamp) <= self.timeout:
            airspeed = self._airspeed
        self.missing = airspeed is None
        if airspeed is not None:
            return measurement.state(airspeed)
        east, north, up = (float(value) for value in measurement.ground_velocity)
        speed = math.sqrt(east**2 + north**2 + up**2)
        if not speed > SLOW:
            return measurement.state(speed)
        heading, path_angle = math.atan2(north, east), math.atan2(up, math.hypot(east, north))
        return np.array([*measurement.position, heading, path_angle, speed])
