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

"""The path of a command, from the situation that it answers, else from the measurement."""

from __future__ import annotations

import numpy as np

from uav_tracking_mpc.control.command import Command
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.planned_path import PathPlanner, PlannedPath
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.estimation.measurement import Measurement


class CommandPaths:
    """Where commands lead, whatever they come from: a plan, a law, or wings level."""

    def __init__(self) -> None:
        self._planner = PathPlanner()

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
            wind = controller.navigator.wind
            path = self._planner.path(present.vehicle, present.rates, wind, *answer)
            if np.isfinite(path.states).all():
                return path
        vehicle = controller.navigator.vehicle_state(measurement)
        rates = np.array([measurement.turn_rate, measurement.path_angle_rate, 0.0])
        wind = measurement.ground_velocity - velocity(vehicle)
        return self._planner.path(vehicle, rates, wind, *answer)
