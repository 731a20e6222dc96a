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

"""What is measured of the aircraft at one time, and what a source tells of its noise.

Unknown are variances of which none is positive, one is negative or not finite, or one is so large
that it says nothing. An axis of 0 beside others that are known counts as their mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import ArrayLike, NDArray

# Standard deviations beyond which a source says nothing of where the aircraft is and how it flies
NOISE_LIMITS = {
    "position": 100.0,  # m
    "velocity": 10.0,  # m/s
    "heading": 0.5,  # rad
    "path_angle": 0.5,  # rad
    "airspeed": 10.0,  # m/s
}

NUMBERS = ("stamp", "heading", "path_angle", "turn_rate", "path_angle_rate", "airspeed", "bank")
MISSING = ("airspeed", "bank")  # of these, what a source need not measure


class MeasurementError(ValueError):
    """A measurement cannot be used; the text names the value and what is allowed."""


def vector(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Three finite numbers, shape (3,), in an array of its own: the caller's may change.

    Args:
        name: What they are, for the error.
        values: In any unit.

    Raises:
        MeasurementError: They are not three, or not finite.
    """
    numbers = np.array(values, dtype=float)
    if numbers.shape != (3,) or not all(map(math.isfinite, numbers.tolist())):
        raise MeasurementError(f"{name} is {values!r}, must be three finite numbers")
    return numbers


def makes_sense(variances: Sequence[float]) -> bool:
    """Whether variances are of a covariance, and known.

    Args:
        variances: In any unit [SI].
    """
    # The sum is finite only if each of them is.
    return min(variances) >= 0.0 and 0.0 < sum(variances) < math.inf


def told_noise(name: str, variances: Sequence[float]) -> tuple[float, ...]:
    """Standard deviation of each axis, in its unit [SI]; zeros where unknown.

    Args:
        name: As of :class:`SensorNoise`.
        variances: Of each axis, in the square of the unit [SI].
    """
    if not makes_sense(variances) or max(variances) > NOISE_LIMITS[name] ** 2:
        return (0.0,) * len(variances)
    known = [variance for variance in variances if variance > 0.0]
    mean = sum(known) / len(known)
    return tuple(math.sqrt(variance or mean) for variance in variances)


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of a measurement, as far as its source knows them; 0 where it does not.

    Attributes:
        position: Of the position on each axis of ``map``, shape (3,), in [m].
        velocity: Of the ground velocity on each axis of ``map``, shape (3,), in [m/s].
        heading: In [rad].
        path_angle: In [rad].
        airspeed: In [m/s].

    Raises:
        MeasurementError: One is negative, not finite, or so large that it says nothing.
    """

    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0)
    heading: float = 0.0
    path_angle: float = 0.0
    airspeed: float = 0.0

    @classmethod
    def told(
        cls, position: Sequence[float], velocity: Sequence[float], heading: float, path_angle: float
    ) -> SensorNoise:
        """Noise by the variances that a source tells, as far as they make sense.

        Args:
            position: Of three axes in [m^2].
            velocity: Of three axes in [m^2/s^2].
            heading: In [rad^2].
            path_angle: In [rad^2].
        """
        return cls(
            told_noise("position", position),
            told_noise("velocity", velocity),
            *told_noise("heading", [heading]),
            *told_noise("path_angle", [path_angle]),
        )

    def __post_init__(self) -> None:
        """Refuse what is no standard deviation."""
        for name, limit in NOISE_LIMITS.items():
            values = getattr(self, name)
            axes = values if isinstance(values, tuple) else (values,)
            wanted = 3 if name in ("position", "velocity") else 1
            if len(axes) != wanted or not all(0.0 <= value <= limit for value in axes):
                raise MeasurementError(
                    f"noise of {name} is {values!r}, must be {wanted} in 0..{limit:g}, 0 if unknown"
                )


class Axis(Enum):
    """Which axis a heading and a path angle are of, and what tells how it turns."""

    BODY = "body"  # forward axis of the attitude; rates by the gyros
    AIR_VELOCITY = "air_velocity"  # velocity through the air; rates as the path turns


SILENT = SensorNoise()  # of a source that tells nothing of its noise


@dataclass(frozen=True)
class Measurement:
    """Where the aircraft is and how it moves.

    Attributes:
        stamp: Time of the measurement in [s], by the clock that stamps all others.
        position: In ``map``, shape (3,), in [m]; three times no number (NaN) where it is not known
            now: with ``air_estimation`` the ground velocity then carries the last one on.
        ground_velocity: In ``map``, shape (3,), in [m/s].
        heading: psi, counter-clockwise from East, of the axis in [rad].
        path_angle: chi, the elevation of the axis, in [rad].
        turn_rate: psi' in [rad/s]; 0 where it is not known: it is then found from the heading.
        path_angle_rate: chi' in [rad/s]; 0 likewise.
        airspeed: v in [m/s]; None where the source has no air data, and no number (NaN) likewise.
        noise: What is known of the sensors' noise.
        bank: Of the body, right wing down, in [rad]; None or NaN where the source tells none.
        axis: Which axis is measured. The controller flies the air velocity: that of a body whose
            bank is told is found from bank and climb, and a body without one is taken to point
            along it (:mod:`~uav_tracking_mpc.estimation.flight_path`).

    Raises:
        MeasurementError: A value is not finite, or not of its shape or type.
    """

    stamp: float
    position: NDArray[np.float64]
    ground_velocity: NDArray[np.float64]
    heading: float
    path_angle: float
    turn_rate: float = 0.0
    path_angle_rate: float = 0.0
    airspeed: float | None = None
    noise: SensorNoise = SILENT
    bank: float | None = None
    axis: Axis = Axis.BODY

    def __post_init__(self) -> None:
        """Refuse what is no measurement; copy the vectors, which must not change afterwards."""
        position = np.array(self.position, dtype=float)
        if position.shape != (3,) or not all(map(math.isnan, position.tolist())):
            position = vector("position", self.position)
        object.__setattr__(self, "position", position)
        object.__setattr__(self, "ground_velocity", vector("ground_velocity", self.ground_velocity))
        for name in NUMBERS:
            value = getattr(self, name)
            if name in MISSING and (value is None or math.isnan(value)):
                object.__setattr__(self, name, None)
            elif not math.isfinite(value):
                raise MeasurementError(f"{name} is {value!r}, must be a finite number")
        if self.bank is not None and abs(self.bank) > math.pi:
            raise MeasurementError(f"bank is {self.bank!r}, must be from -pi to pi rad")
        for name, wanted in (("axis", Axis), ("noise", SensorNoise)):
            if not isinstance(value := getattr(self, name), wanted):
                raise MeasurementError(f"{name} is {value!r}, must be of {wanted.__name__}")

    @property
    def placed(self) -> bool:
        """Whether the position is known."""
        return not math.isnan(self.position[0])

    def state(self, airspeed: float) -> NDArray[np.float64]:
        """State of the vehicle (3) whose air velocity points along the body.

        Args:
            airspeed: v in [m/s].

        Returns:
            (x, y, z, psi, chi, v), shape (6,).
        """
        return np.array([*self.position.tolist(), self.heading, self.path_angle, airspeed])
