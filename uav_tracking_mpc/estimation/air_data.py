"""The airspeed that belongs to a state; without a measurement the air is taken as still."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.nodes.conversions import Motion

SLOW = 0.1  # m/s over ground, below which the pose tells where the vehicle goes


class AirData:
    """Latest airspeed.

    Args:
        timeout: Age, against the state, at which it counts no more, in [s].
    """

    def __init__(self, timeout: float) -> None:
        self.timeout = timeout
        self.reset()

    def reset(self) -> None:
        """Forget the airspeed; say anew if there is none."""
        self._stamp: int | None = None
        self._airspeed = math.nan
        self._said = False

    def take(self, stamp: int, airspeed: float) -> None:
        """An airspeed [m/s] has been measured at a stamp [ns]."""
        self._stamp, self._airspeed = stamp, airspeed

    def vehicle_state(self, stamp: int, motion: Motion, logger: Any) -> NDArray[np.float64]:
        """(x, y, z, psi, chi, v) of position and air velocity, shape (6,).

        In still air the velocity over ground is that through the air.
        """
        if self._stamp is not None and abs(stamp - self._stamp) <= self.timeout * 1e9:
            return motion.state(self._airspeed)
        if not self._said:
            self._said = True
            logger.warning("no airspeed on uav/air_velocity: the air is taken as still")
        east, north, up = (float(value) for value in motion.ground_velocity)
        speed = math.sqrt(east**2 + north**2 + up**2)
        state = motion.state(speed)
        if speed > SLOW:
            state[3], state[4] = math.atan2(north, east), math.atan2(up, math.hypot(east, north))
        return state
