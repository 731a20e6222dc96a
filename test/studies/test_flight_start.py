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

"""Random states, where a flight starts."""

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.estimation.situation import Situation
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.flight_start import flight_start


@pytest.mark.parametrize(
    ("vehicle", "wind", "turn_rate"),
    [
        ((118.384, -686.401, 132.0, 0.878271, -0.121208, 28.9703), (-5.27782, 1.23583), -0.232507),
        (
            (-357.002, 543.012, 129.632, -1.63204, -0.0509808, 31.7371),
            (-0.21172, 0.06444),
            0.269491,
        ),
    ],
)
def test_a_guess_that_must_turn_half_a_circle_does_not_end_on_the_wrong_side(
    vehicle, wind, turn_rate
):
    parameters = dataclasses.replace(
        load_configuration("small_uav").controller, solve_time_max=10.0
    )
    formulation = FlightFormulation(parameters)
    situation = Situation(
        np.array(vehicle),
        np.zeros(3),
        np.array([*wind, 0.0]),
        np.zeros(3),
        np.array([turn_rate, 0.0, 0.0]),
    )
    start = flight_start(formulation, situation)
    plan = formulation.solver.solve(
        start.state, start.parameters, None, lambda: start.guess(start.state)
    )
    assert plan.converged
    assert plan.violation < 1e-6
