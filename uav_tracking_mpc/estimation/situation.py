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

r"""What a guidance law needs to know: aircraft, target, the drift between them; and a forecast.

In a forecast the target goes on turning (:mod:`~uav_tracking_mpc.estimation.target_track`); what
its newest measurement has changed fades in. The mean wind stays, the gust of now fades with its
correlation time T: at a time t from now, with wind w, gust g, the target's velocity v and
acceleration a,

.. math:: c = w + e^{-t / T} g - v, \qquad c' = -e^{-t / T} g / T - a.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.target_track import REWIND, TURN
from uav_tracking_mpc.symbolic.layout import Layout

# s: a measurement corrects the target's track by steps. They are faded in with this time constant,
# or those of a noisy track would go straight into the bank angle.
FADE_TIME = 1.0
# What a forecast is made from. Of the target's track (p, v, a) [m, m/s, m/s^2], the variance of
# that acceleration [m^2/s^4], the turn rate [rad/s], since the track's time the time travelled [s]
# and the share of the velocity that is left [-] (:func:`bridged`), what is not yet corrected of
# position [m] and velocity [m/s]; mean wind [m/s], its trend [m/s^2], gust [m/s] and how long gusts
# last on each axis [s].
KNOWN = Layout(
    motion=9, variance=1, turn_rate=1, travelled=1, left=1, faded=6,
    wind=3, trend=3, gust=3, times=3,
)  # fmt: skip


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

    @cached_property
    def relative_velocity(self) -> NDArray[np.float64]:
        """Rate of :attr:`offset`: air velocity plus drift, shape (3,), in [m/s]."""
        return self.air_velocity + self.drift

    def tracking_error(self, orbit: Orbit) -> NDArray[np.float64]:
        """Tracking error of the relative motion (Section 3.1), shape (5,), angles wrapped.

        The bearing is that of the relative velocity: on the orbit it is right whatever the drift.

        Args:
            orbit: What is wanted.

        Returns:
            Errors of range [m], bearing [rad], altitude [m], path angle [rad] and airspeed [m/s].
        """
        x, y, z = self.offset.tolist()
        east, north, _ = self.relative_velocity.tolist()
        *_, path_angle, airspeed = self.vehicle.tolist()
        bearing = math.remainder(
            math.atan2(north, east) - math.atan2(y, x) - math.pi - orbit.bearing, 2.0 * math.pi
        )
        range_, altitude = orbit.errors_at(x, y, z)
        return np.array([range_, bearing, altitude, path_angle, airspeed - orbit.speed])


class Forecast(NamedTuple):
    """Target and drift at the stages 0..N of a plan.

    Attributes:
        target: Position in ``map``, shape (N + 1, 3), in [m].
        drift: c, shape (N + 1, 3), in [m/s].
        drift_rate: c', shape (N + 1, 3), in [m/s^2].
        gust_walk: Intensity of level gusts in [m^2/s^3]; infinite where nothing is known of them.
    """

    target: NDArray[np.float64]
    drift: NDArray[np.float64]
    drift_rate: NDArray[np.float64]
    gust_walk: float = 0.0


def steady_forecast(situation: Situation, stages: int) -> Forecast:
    """Present drift and target throughout.

    Args:
        situation: Present target and drift.
        stages: N.
    """
    ahead = (stages + 1, 1)
    return Forecast(
        np.tile(situation.target, ahead), np.tile(situation.drift, ahead), np.zeros((stages + 1, 3))
    )


@functools.cache
def outlook(count: int) -> ca.Function:
    """Position of the target in ``map`` [m], c [m/s] and c' [m/s^2], at several times.

    Of what is known by :data:`KNOWN`, and the times from now on [s], shape (n,); the result has a
    column each, shape (9, n). To derive it takes fifty milliseconds.

    Args:
        count: n, how many times.
    """
    known, told = KNOWN.symbol("known")
    times = ca.SX.sym("times", count)
    columns = []
    for time in ca.vertsplit(times):
        lead = ca.fmax(told.travelled + told.left * time, -REWIND)
        ahead = TURN(told.motion, told.variance, told.turn_rate, lead)
        position, velocity, acceleration = ca.vertsplit(ahead, 3)
        fades = ca.exp(-time / FADE_TIME) * told.faded
        blowing = ca.exp(-time / told.times) * told.gust
        drift = told.wind + time * told.trend + blowing - told.left * velocity - fades[3:]
        drift_rate = told.trend - blowing / told.times - told.left**2 * acceleration
        columns.append(ca.densify(ca.vertcat(position + fades[:3], drift, drift_rate)))
    return ca.Function("outlook", [known, times], [ca.horzcat(*columns)], {"cse": True})
