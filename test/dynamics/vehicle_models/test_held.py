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

"""The vehicle whose autopilot holds altitude and airspeed."""

import math

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc.dynamics.energy_hold import hold
from uav_tracking_mpc.dynamics.vehicle_models import Drift, VehicleState
from uav_tracking_mpc.dynamics.vehicle_models.held import Held
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged

LAG = (0.3, 0.13, 0.16)
MODEL = Held(rate_lag=LAG, hold_time=(4.0, 0.8, 3.0), hold_climb_max=4.0)
STATE = VehicleState(200.0, -80.0, 40.0, 2.9, 0.05, 20.0, 0.1, -0.05, 0.4)
DRIFT = [6.0, -3.0, 0.5]


def held(state, altitude=60.0, airspeed=22.0, drift=DRIFT):
    return MODEL.held(state, altitude, airspeed, MODEL.numbers(0.4), drift)


def test_the_autopilot_flies_its_law_towards_what_it_is_told():
    climb_rate = 20.0 * math.sin(0.05) + 0.5
    expected = hold(20.0, climb_rate, 0.05, 20.0, 2.0, MODEL.hold_constants, math)
    np.testing.assert_allclose(held(STATE), expected)


def test_a_step_is_that_of_the_lagged_vehicle():
    inputs, drift = [0.1, *held(STATE)], Drift(DRIFT, [0.0, 0.0, 0.0])
    lagged = Lagged(LAG)
    expected = lagged.step(STATE, inputs, 0.4, lagged.numbers(0.4), drift)
    assert MODEL.step(STATE, inputs, 0.4, MODEL.numbers(0.4), drift) == expected


def test_numbers_arrays_and_symbols_give_the_same():
    symbols = ca.SX.sym("x", 9)
    function = ca.Function("held", [symbols], held(VehicleState(*ca.vertsplit(symbols))))
    symbolic = [float(value) for value in function(np.array(STATE))]
    np.testing.assert_allclose(symbolic, held(STATE), rtol=1e-13)
    stacked = VehicleState(*np.tile(np.array(STATE)[:, np.newaxis], 4))
    drift = np.tile(np.array(DRIFT)[:, np.newaxis], 4)
    np.testing.assert_allclose(held(stacked, drift=drift)[0], held(STATE)[0])


@pytest.mark.parametrize("start", [-60.0, 40.0])
def test_step_by_step_the_altitude_comes_back(start):
    state = VehicleState(0.0, 0.0, 60.0 + start, 0.0, 0.0, 18.0, 0.0, 0.0, 0.0)
    numbers, drift = MODEL.numbers(0.4), Drift([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
    for _ in range(200):
        state = MODEL.step(state, [0.0, *held(state, drift=[0.0, 0.0, 1.0])], 0.4, numbers, drift)
    assert state.z == pytest.approx(60.0, abs=0.01)
    assert state.airspeed == pytest.approx(22.0, abs=0.01)
    assert 22.0 * math.sin(state.path_angle) == pytest.approx(-1.0, abs=0.01)
