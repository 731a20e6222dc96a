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

"""What the sensors of a simulated aircraft make of the truth: it, with noise, biases and delay.

They tell how noisy they are as far as ``uav/odometry`` carries it, which knows no airspeed, and
keep quiet about biases, as real ones do.
"""

from __future__ import annotations

import dataclasses
import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.frames import wrap_angle
from uav_tracking_mpc.estimation.measurement import Measurement, SensorNoise
from uav_tracking_mpc.estimation.told_noise import axes_noise, scalar_noise
from uav_tracking_mpc.settings.simulator import SimulatorParameters

# Parameters that may change while it measures.
ERRORS = (
    *("position_noise", "velocity_noise", "attitude_noise", "airspeed_noise"),
    *("velocity_bias", "heading_bias", "airspeed_bias", "turn_rate_bias", "position_bias"),
    *("airspeed_fault", "position_fault", "velocity_gain"),
)
TIME_ROUNDING = 1e-9  # s, rounding by which a measurement may be too young


class VehicleSensors:
    """Adds noise and biases, and holds back; without any of them the truth is measured.

    Args:
        parameters: Standard deviations, biases and delay.
        seed: Of the noise.
    """

    def __init__(self, parameters: SimulatorParameters, seed: np.random.SeedSequence) -> None:
        self._held: deque[Measurement] = deque()
        self._left: tuple[float, float] | None = None  # airspeed [m/s], height [m] as it got stuck
        self._place: NDArray[np.float64] | None = None  # at which the position is frozen
        self._random = np.random.default_rng(seed)
        self.change(parameters)

    def change(self, parameters: SimulatorParameters) -> None:
        """Measure with other noise and biases from now on; what is held back stays as it is.

        Args:
            parameters: Standard deviations, biases and delay.
        """
        self._deviations = np.array(
            [
                *[parameters.position_noise] * 3,
                *[parameters.attitude_noise] * 2,
                parameters.airspeed_noise,
                *[parameters.velocity_noise] * 3,
            ]
        )
        self._told = _told(parameters)
        heading, airspeed = parameters.heading_bias, parameters.airspeed_bias
        self._biases = np.array(
            [*parameters.position_bias, heading, 0.0, airspeed, *parameters.velocity_bias]
        )
        self._airspeed_fault = parameters.airspeed_fault
        self._frozen = parameters.position_fault == "frozen"
        self._unplaced = parameters.position_fault == "silent"
        if self._airspeed_fault not in ("stuck", "blocked"):
            self._left = None
        if not self._frozen:
            self._place = None
        self._turn_rate_bias = parameters.turn_rate_bias
        self._velocity_gain = parameters.velocity_gain
        placed = parameters.position_fault == "none"
        faulty = self._airspeed_fault != "none", not placed, self._velocity_gain != 1.0
        errors = *self._deviations, *self._biases, self._turn_rate_bias
        self._wrong = any(errors) or any(faulty)
        self._delay, self._stamp_true = parameters.state_delay, parameters.state_stamp_true

    def measure(self, truth: Measurement) -> Measurement:
        """What is measured; every call draws anew.

        Args:
            truth: State of the aircraft, not older than the one before.

        Returns:
            The newest measurement that is as old as the delay; until there is one, the first.
        """
        measured = self._mistaken(truth) if self._wrong else truth
        if self._delay == 0.0:
            return measured
        self._held.append(measured)
        latest = truth.stamp - self._delay + TIME_ROUNDING
        while len(self._held) > 1 and self._held[1].stamp <= latest:
            self._held.popleft()
        late = self._held[0]
        return late if self._stamp_true else dataclasses.replace(late, stamp=truth.stamp)

    def _mistaken(self, truth: Measurement) -> Measurement:
        errors = self._biases.copy()
        if self._deviations.any():
            errors += self._deviations * self._random.standard_normal(len(errors))
        position, attitude, ground_velocity = errors.reshape(3, 3)
        heading, path_angle, airspeed = attitude.tolist()
        right_angle = 0.5 * math.pi
        place = truth.position + position
        if self._frozen:
            self._place = place = place if self._place is None else self._place
        return dataclasses.replace(
            truth,
            position=np.full(3, np.nan) if self._unplaced else place,
            ground_velocity=self._velocity_gain * truth.ground_velocity + ground_velocity,
            heading=float(wrap_angle(truth.heading + heading)),
            path_angle=min(max(truth.path_angle + path_angle, -right_angle), right_angle),
            turn_rate=truth.turn_rate + self._turn_rate_bias,
            airspeed=self._airspeed(truth, airspeed),
            noise=self._told,
        )

    def _airspeed(self, truth: Measurement, error: float) -> float | None:
        """Reading of the airspeed sensor, as its fault lets it through."""
        if truth.airspeed is None or self._airspeed_fault == "silent":
            return None
        height, reading = float(truth.position[2]), max(truth.airspeed + error, 0.0)
        if self._airspeed_fault == "none":
            return reading
        if self._left is None:
            self._left = reading, height
        airspeed, sealed = self._left
        if self._airspeed_fault == "stuck":
            return airspeed
        # The static pressure falls by rho g per metre, that in the blocked tube does not.
        return math.sqrt(max(airspeed**2 + 2.0 * GRAVITY * (height - sealed), 0.0))


def _told(parameters: SimulatorParameters) -> SensorNoise:
    """Noise as the sensors tell it; what is beyond all measure is not told."""
    attitude = parameters.attitude_noise**2
    return SensorNoise(
        axes_noise("position", [parameters.position_noise**2] * 3),
        axes_noise("velocity", [parameters.velocity_noise**2] * 3),
        scalar_noise("heading", attitude),
        scalar_noise("path_angle", attitude),
    )
