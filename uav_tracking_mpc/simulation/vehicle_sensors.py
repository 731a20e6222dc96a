"""What the sensors of a simulated aircraft make of the truth: it, with white noise."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from uav_tracking_mpc.dynamics.angles import wrap_angle
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.simulator import SimulatorParameters


class VehicleSensors:
    """Adds noise; without noise the truth is measured.

    Args:
        parameters: Standard deviations.
        seed: Of the noise.
    """

    def __init__(self, parameters: SimulatorParameters, seed: np.random.SeedSequence) -> None:
        self._deviations = np.array(
            [
                *[parameters.position_noise] * 3,
                *[parameters.attitude_noise] * 2,
                parameters.airspeed_noise,
                *[parameters.velocity_noise] * 3,
            ]
        )
        self._noisy = bool(np.any(self._deviations))
        self._random = np.random.default_rng(seed)

    def measure(self, truth: Measurement) -> Measurement:
        """What is measured; every call draws anew.

        Args:
            truth: State of the aircraft.
        """
        if not self._noisy:
            return truth
        noise = self._deviations * self._random.standard_normal(len(self._deviations))
        position, attitude, ground_velocity = noise.reshape(3, 3)
        heading, path_angle, airspeed = attitude.tolist()
        airspeed = None if truth.airspeed is None else max(truth.airspeed + airspeed, 0.0)
        right_angle = 0.5 * math.pi
        return dataclasses.replace(
            truth,
            position=truth.position + position,
            ground_velocity=truth.ground_velocity + ground_velocity,
            heading=float(wrap_angle(truth.heading + heading)),
            path_angle=min(max(truth.path_angle + path_angle, -right_angle), right_angle),
            airspeed=airspeed,
        )
