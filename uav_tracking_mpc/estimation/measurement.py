"""What is measured of the aircraft at one time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


class MeasurementError(ValueError):
    """A measurement cannot be used; the text names the value and what is allowed."""


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of a measurement, as far as its source knows them.

    Attributes:
        position: Of the position on each axis in [m].
        velocity: Of the ground velocity on each axis in [m/s].
        attitude: Of heading and path angle in [rad].
        airspeed: In [m/s].
    """

    position: float = 0.0
    velocity: float = 0.0
    attitude: float = 0.0
    airspeed: float = 0.0


@dataclass(frozen=True)
class Measurement:
    """Where the aircraft is and how it moves.

    Attributes:
        stamp: Time of the measurement in [s], by the clock that stamps all others.
        position: In ``map``, shape (3,), in [m].
        ground_velocity: In ``map``, shape (3,), in [m/s].
        heading: psi of the body in [rad].
        path_angle: chi, the climb of the body's axis, in [rad].
        turn_rate: psi' in [rad/s].
        path_angle_rate: chi' in [rad/s].
        airspeed: v in [m/s]; None where the source has no air data.
        noise: What is known of the sensors' noise; None for nothing.

    Raises:
        MeasurementError: A value is not finite, or not of its shape.
    """

    stamp: float
    position: NDArray[np.float64]
    ground_velocity: NDArray[np.float64]
    heading: float
    path_angle: float
    turn_rate: float = 0.0
    path_angle_rate: float = 0.0
    airspeed: float | None = None
    noise: SensorNoise | None = None

    def __post_init__(self) -> None:
        """Refuse what is no measurement; copy the vectors, which must not change afterwards."""
        for name in ("position", "ground_velocity"):
            vector = np.array(getattr(self, name), dtype=float)
            if vector.shape != (3,) or not np.isfinite(vector).all():
                raise MeasurementError(
                    f"{name} is {getattr(self, name)!r}, must be three finite numbers"
                )
            object.__setattr__(self, name, vector)
        for name in ("stamp", "heading", "path_angle", "turn_rate", "path_angle_rate", "airspeed"):
            value = getattr(self, name)
            if not (value is None and name == "airspeed") and not math.isfinite(value):
                raise MeasurementError(f"{name} is {value!r}, must be a finite number")

    def state(self, airspeed: float) -> NDArray[np.float64]:
        """State of the vehicle (3) whose air velocity points along the body.

        Args:
            airspeed: v in [m/s].

        Returns:
            (x, y, z, psi, chi, v), shape (6,).
        """
        return np.array([*self.position, self.heading, self.path_angle, airspeed])
