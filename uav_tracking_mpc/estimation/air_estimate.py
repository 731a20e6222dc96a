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

"""Aircraft and air as they are known: what is measured, less what sensors get wrong.

Three filters of the wind run side by side. One knows all sensors, and is what is flown by. One owes
nothing to the airspeed, one nothing to the heading: each judges the sensor that it does not know,
and tells what stands in for it. Where a sensor is found wrong, the first goes on from the one that
nothing wrong has come into.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics import vehicle as vehicle_model
from uav_tracking_mpc.estimation.air_check import AirCheck, loose_air
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.estimation.rate_aided_filter import RateAided, RateAidedFilters
from uav_tracking_mpc.estimation.sensor_health import (
    AIRSPEED,
    HEADING,
    POSITION,
    SILENT,
    USED,
    VELOCITY,
    SensorHealth,
)
from uav_tracking_mpc.estimation.wind_filter import WindFilter

# What the filters begin with: noise of a rate per root of Hz and standard deviation of its bias, in
# [rad/s] as measured and in [m/s^2] as computed from the commands; least noise of what is measured.
GYRO, ACCELERATION_MODEL = (1e-3, 0.05), (0.1, 0.5)
ATTITUDE_NOISE, AIRSPEED_NOISE = 1e-3, 0.05  # rad, m/s
LEAST_LEVEL = 0.1  # -, share of the airspeed, below which the wind tells nothing of it


class AircraftInAir(NamedTuple):
    """Aircraft and air as they are known.

    Attributes:
        vehicle: (x, y, z, psi, chi, v) through the air, shape (6,), in [m], [rad] and [m/s].
        rates: (psi', chi', v'), shape (3,), in [rad/s] and [m/s^2].
        wind: Mean wind in ``map``, shape (3,), in [m/s].
        trend: How the mean wind changes, shape (3,), in [m/s^2].
        gust: Shape (3,), in [m/s].
        correlation_times: How long gusts last on each axis, shape (3,), in [s].
    """

    vehicle: NDArray[np.float64]
    rates: NDArray[np.float64]
    wind: NDArray[np.float64]
    trend: NDArray[np.float64]
    gust: NDArray[np.float64]
    correlation_times: NDArray[np.float64]


class AirEstimate:
    """Measurements in, aircraft and air out.

    Attributes:
        filter: Of mean wind, gusts and biases, by all sensors that are used.
        check: Which of airspeed and heading are left out.
        health: Of all sensors.
    """

    def __init__(self) -> None:
        self.filter, self.check, self.health = WindFilter(), AirCheck(), SensorHealth()
        self._without = WindFilter(), WindFilter()  # airspeed; heading
        angle = RateAided(*GYRO, ATTITUDE_NOISE, circular=True)
        speed = RateAided(*ACCELERATION_MODEL, AIRSPEED_NOISE, circular=False)
        self._motion = RateAidedFilters([angle, angle, speed])  # heading, path angle, airspeed

    def reset(self) -> None:
        """Forget the air and believe every sensor."""
        for part in (self.filter, *self._without, self.check, self._motion, self.health):
            part.reset()

    def update(
        self,
        measurement: Measurement,
        vehicle: NDArray[np.float64],
        rates: NDArray[np.float64],
        height: float,
        missing: bool,
    ) -> AircraftInAir:
        """Take in a measurement.

        Args:
            measurement: Of the path through the air.
            vehicle: (x, y, z, psi, chi, v) of it, shape (6,).
            rates: psi' and chi' as measured in [rad/s], v' as commanded in [m/s^2], shape (3,).
            height: Above ground in [m], for the length of the gusts.
            missing: Whether there is no airspeed.
        """
        filters, noise, check, rates = self._motion, measurement.noise, self.check, rates.copy()
        stamp, place, air = measurement.stamp, vehicle[:3], self.filter
        seen = stamp, place, measurement.ground_velocity
        ground = air.believed(*seen, noise.velocity)
        before = list(check.reasons)
        motion, by_wind = self._by_wind(measurement, vehicle, ground, missing, float(rates[2]))
        told = noise.heading, noise.path_angle, noise.airspeed
        filters.update(stamp, motion, rates, told)
        heading, path_angle, airspeed = filters.values.tolist()
        about = height, noise.position, noise.velocity
        out = [bool(reason) for reason in check.reasons]
        for which, lane in (*enumerate(self._without), (None, air)):
            guess = [heading, airspeed]
            if which is not None:
                lane.share_noise(air)
                guess[1 - which] = by_wind[1 - which]
            loose = loose_air(heading, out[0] or which == 0, out[1] or which == 1)
            velocity = vehicle_model.air_velocity(guess[0], path_angle, guess[1], math)
            lane.update(*seen, np.array(velocity), *about, loose)
        for lane, reason, earlier in zip(self._without, check.reasons, before, strict=True):
            if reason not in ("", SILENT) and reason != earlier:
                air.begin_as(lane)  # which nothing wrong has come into
        for sensor, state in (
            *zip((AIRSPEED, HEADING), check.reasons, strict=True),
            (POSITION, air.place),
            (VELOCITY, air.velocity),
        ):
            self.health.states[sensor] = state or USED
        heading = math.remainder(heading - air.heading_bias, 2.0 * math.pi)
        airspeed *= 1.0 - air.airspeed_share
        rates[:2] -= filters.biases[:2]
        return AircraftInAir(
            np.array([*air.position, heading, path_angle, airspeed]),
            rates,
            air.mean_wind,
            air.trend,
            air.gust,
            air.correlation_times,
        )

    def _by_wind(
        self,
        measurement: Measurement,
        vehicle: NDArray[np.float64],
        ground: NDArray[np.float64],
        missing: bool,
        acceleration: float,
    ) -> tuple[NDArray[np.float64], tuple[float, float]]:
        """Heading, path angle, airspeed to go by; and heading, airspeed that the wind tells.

        What judges a sensor and stands in for it is a filter that does not know that sensor.
        """
        heading, path_angle, airspeed = vehicle[3:].tolist()
        cosine = max(math.cos(path_angle), LEAST_LEVEL)
        level = max(cosine * (1.0 - self.filter.airspeed_share), LEAST_LEVEL)
        air = [(ground - lane.ground_velocity_bias - lane.mean_wind)[:2] for lane in self._without]
        deviations = [lane.wind_deviation for lane in self._without]
        reading = None if missing else airspeed
        if missing:
            heading = measurement.heading
        without = self._without[0]
        level_wind = (without.mean_wind + without.gust)[:2]
        explained = np.array([*level_wind, without.heading_bias * airspeed])
        known = air, deviations, explained, acceleration
        turned, along = self.check.judge(measurement.stamp, heading, reading, level, *known)
        by_wind = turned, along / cosine
        out = self.check.reasons
        going_by = by_wind[0] if out[1] else heading
        flown = by_wind[1] if reading is None or out[0] else reading
        return np.array([going_by, path_angle, flown]), by_wind
