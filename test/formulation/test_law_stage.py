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

"""One stage of a law's flight, against the same in plain Python."""

import numpy as np
import small_uav

from uav_tracking_mpc.dynamics.vehicle_models import Drift
from uav_tracking_mpc.estimation.forecast import steady_forecast
from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation


class NoSolver:
    """For a formulation that only states its problem."""


def test_a_stage_flies_the_shares_nearest_to_what_the_law_wants():
    parameters = small_uav.parameters()
    formulation = FlightFormulation(parameters, NoSolver())
    flight, model, step = formulation.flight, formulation.model, formulation.step
    random = np.random.default_rng(3)
    clipped = 0
    for _ in range(50):
        now = small_uav.situation(
            x=random.uniform(-600.0, 600.0),
            y=random.uniform(100.0, 600.0),
            heading=random.uniform(-3.0, 3.0),
            drift=(random.uniform(-8.0, 8.0), 3.0, 0.0),
        )
        data = formulation.data(steady_forecast(now, parameters.horizon), parameters.orbit)[0]
        x_0, wanted = formulation.initial_state(now), random.uniform(-1.0, 1.0, 3)
        state = model.State(*x_0.tolist())
        middle, half = (np.array(part) for part in flight.span(state, data))
        expected = np.clip((wanted - middle) / half, -1.0, 1.0)
        clipped += np.sum(np.abs(expected) == 1.0)
        flown = [float(u) for u in flight.inputs(expected, state, data)]
        drift = Drift(now.drift.tolist(), now.drift_rate.tolist())
        numbers = model.numbers(step).tolist()
        shares, following = flight.law_stage(x_0, wanted, data)
        np.testing.assert_allclose(shares, expected, atol=1e-12)
        np.testing.assert_allclose(
            following, model.step(state, flown, step, numbers, drift), rtol=1e-12, atol=1e-12
        )
    assert 10 < clipped < 140  # inside of the box and at its bounds
