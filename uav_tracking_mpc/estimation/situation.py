"""What a guidance law needs to know: the aircraft, the target, and the drift between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.vehicle import velocity


@dataclass(frozen=True)
class Situation:
    """Aircraft and target at one time.

    Wind and target's velocity matter only by their difference, the drift c: seen from the target
    the air moves with c, and the aircraft with its air velocity plus c.

    Attributes:
        vehicle: (x, y, z, psi, chi, v), shape (6,); heading, path angle and speed are those of
            the air velocity.
        target: Position in ``map``, shape (3,), in [m].
        drift: c, wind velocity less target velocity, shape (3,), in [m/s].
        drift_rate: c', shape (3,), in [m/s^2]; under a steady wind minus the target's acceleration.
        rates: (u_psi, u_chi, u_v) flown now, which lag behind those commanded, shape (3,).
    """

    vehicle: NDArray[np.float64]
    target: NDArray[np.float64]
    drift: NDArray[np.float64]
    drift_rate: NDArray[np.float64]
    rates: NDArray[np.float64]

    @property
    def heading(self) -> float:
        """Heading psi of the air velocity in [rad]."""
        return float(self.vehicle[3])

    @property
    def path_angle(self) -> float:
        """Path angle chi of the air velocity in [rad]."""
        return float(self.vehicle[4])

    @property
    def airspeed(self) -> float:
        """Airspeed v in [m/s]."""
        return float(self.vehicle[5])

    @property
    def offset(self) -> NDArray[np.float64]:
        """From the target to the aircraft, shape (3,), in [m]."""
        return self.vehicle[:3] - self.target

    @property
    def air_velocity(self) -> NDArray[np.float64]:
        """Velocity through the air, shape (3,), in [m/s]."""
        return velocity(self.vehicle)

    @property
    def relative_velocity(self) -> NDArray[np.float64]:
        """Rate of :attr:`offset`: air velocity plus drift, shape (3,), in [m/s]."""
        return self.air_velocity + self.drift
