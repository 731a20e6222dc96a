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

"""A situation as the flight problem takes it: where a closed loop on the prediction begins."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uav_tracking_mpc.control.guidance import nearest_direction
from uav_tracking_mpc.dynamics.orbit import Orbit
from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.mpc.solver import Guess
from uav_tracking_mpc.settings.tracking import NEAREST, TrackingParameters


@dataclass(frozen=True)
class Start:
    """What a solver is given to begin.

    Attributes:
        state: x_0, shape (nx,).
        parameters: P of every stage, shape (N + 1, np); None where the problem has none.
        guess: Plan for a cold start from a state, shape (nx,); None leaves it to the solver.
    """

    state: NDArray[np.float64]
    parameters: NDArray[np.float64] | None = None
    guess: Callable[[NDArray[np.float64]], Guess | None] | None = None


def flight_start(formulation: FlightFormulation, situation: Situation) -> Start:
    """Begin at a situation whose drift stays, about a target that stays.

    Args:
        formulation: Of the flight problem.
        situation: Where the flight begins.
    """
    parameters = formulation.parameters
    forecast = steady_forecast(situation, parameters.horizon)
    orbit = wanted_orbit(parameters, situation)
    data = formulation.data(forecast, orbit).copy()

    def guess(state: NDArray[np.float64]) -> Guess | None:
        return formulation.guess(state, forecast, orbit, data)

    return Start(formulation.initial_state(situation), data, guess)


def wanted_orbit(parameters: TrackingParameters, situation: Situation) -> Orbit:
    """The wanted orbit; where the nearest direction is asked for, that of the situation.

    Args:
        parameters: Of the controller.
        situation: Where the flight begins.
    """
    if parameters.direction != NEAREST:
        return parameters.orbit
    return dataclasses.replace(parameters.orbit, direction=nearest_direction(situation))
