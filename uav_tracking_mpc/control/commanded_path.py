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

r"""Where a command leads: positions, attitudes and ground velocities at the stages of its plan.

The inputs u_j, held over a stage each, are flown through the kinematics (3) of the vehicle. A rate
follows its input after a dead time d with a lag tau, and keeps its present value until then. Then
heading, path angle and airspeed are linear in the inputs,

.. math:: \theta(t) = \theta_0 + a(t) r_0 + \sum_j A_j(t) u_j,

with numbers A and a that depend on t, d, tau and the length of a stage alone. Positions are the
integral of the ground velocity by Simpson's rule over each stage; the air moves as it does now.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.dynamics.vehicle import air_velocity, followed, velocity
from uav_tracking_mpc.estimation.measurement import Measurement


class PlannedPath(NamedTuple):
    """A path at 0, step, 2 step, ..., of which the last is the end of the plan.

    Attributes:
        states: (x, y, z, psi, chi, v) in ``map``, shape (n + 1, 6); angles are not wrapped.
        ground_velocities: In ``map``, shape (n + 1, 3), in [m/s].
    """

    states: NDArray[np.float64]
    ground_velocities: NDArray[np.float64]


class CommandPaths:
    """Where commands lead, whatever they come from: a plan, a law, or wings level.

    One plan is as long as the other most of the time, so the numbers of its form are kept.
    """

    def __init__(self) -> None:
        self._form: tuple[object, ...] = ()

    def path(
        self, controller: Controller, measurement: Measurement, command: Command
    ) -> PlannedPath:
        """Path of a command, finite.

        Args:
            controller: That has answered it.
            measurement: That it answers; it counts where the situation is not known.
            command: What is sent.
        """
        response, present = controller.response.flown, command.present
        flown = command.inputs * response.gains
        answer = flown, command.step, response.lags, response.dead_times
        if present is not None:
            path = self.planned(present.vehicle, present.rates, controller.navigator.wind, *answer)
            if np.isfinite(path.states).all():
                return path
        vehicle = measurement.state(measurement.airspeed or controller.navigator.airspeed)
        rates = np.array([measurement.turn_rate, measurement.path_angle_rate, 0.0])
        wind = measurement.ground_velocity - velocity(vehicle)
        return self.planned(vehicle, rates, wind, *answer)

    def planned(
        self,
        vehicle: NDArray[np.float64],
        rates: NDArray[np.float64],
        wind: NDArray[np.float64],
        inputs: NDArray[np.float64],
        step: float,
        lags: NDArray[np.float64],
        dead_times: NDArray[np.float64],
    ) -> PlannedPath:
        """Path of a plan.

        Args:
            vehicle: (x, y, z, psi, chi, v) now, shape (6,).
            rates: (psi', chi', v') now, shape (3,), in [rad/s, rad/s, m/s^2].
            wind: Velocity of the air, shape (3,), in [m/s].
            inputs: (u_psi, u_chi, u_v) of each stage, shape (n, 3), n >= 1.
            step: Length of a stage in [s].
            lags: With which rates follow inputs, shape (3,), in [s].
            dead_times: After which they do, shape (3,), in [s].
        """
        form = len(inputs), step, *lags.tolist(), *dead_times.tolist()
        if form != self._form:
            self._prepare(len(inputs), step, lags, dead_times)
            self._form = form
        air, courses = self._air, self._courses
        self._terms[:, 0, 0], self._terms[:, 1, 0] = vehicle[3:], rates
        self._terms[:, 2:, 0] = inputs.T
        np.matmul(self._numbers, self._terms, out=courses[:, :, np.newaxis])
        heading, path_angle, airspeed = courses
        air[:, 0], air[:, 1], air[:, 2] = air_velocity(heading, path_angle, airspeed, np)
        air += wind
        states = np.empty((len(inputs) + 1, 6))
        states[0, :3] = vehicle[:3]
        np.matmul(self._simpson, air, out=states[1:, :3])
        states[1:, :3] += vehicle[:3]
        states[:, 3:] = courses[:, ::2].T
        return PlannedPath(states, air[::2].copy())

    def _prepare(
        self, count: int, step: float, lags: NDArray[np.float64], dead_times: NDArray[np.float64]
    ) -> None:
        """Numbers of plans of this form, at the stages and in their middles."""
        times = 0.5 * step * np.arange(2 * count + 1)
        self._numbers = np.empty((3, len(times), 2 + count))
        self._numbers[:, :, 0] = 1.0
        for axis in range(3):
            lag, dead_time = float(lags[axis]), float(dead_times[axis])
            begins = dead_time + step * np.arange(count + 1)
            ramps = np.array([_ramp(times - begin, lag) for begin in begins])
            ramps[-1] = 0.0  # the last input is held
            self._numbers[axis, :, 1] = times - ramps[0]
            self._numbers[axis, :, 2:] = (ramps[:-1] - ramps[1:]).T
        self._simpson = np.zeros((count, len(times)))
        weights = step / 6.0 * np.array([1.0, 4.0, 1.0])
        for stage in range(count):
            self._simpson[stage:, 2 * stage : 2 * stage + 3] += weights
        self._terms = np.zeros((3, 2 + count, 1))
        self._courses = np.empty((3, len(times)))
        self._air = np.empty((len(times), 3))


def _ramp(ages: NDArray[np.float64], lag: float) -> NDArray[np.float64]:
    """Integral of the answer to a unit step, so long after it, in [s]."""
    after = np.maximum(ages, 0.0)
    return after - lag * followed(after, lag)
