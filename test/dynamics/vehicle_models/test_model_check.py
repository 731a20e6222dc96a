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

"""The check of a model of the vehicle: the project's and the example pass, wrong ones are named."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from uav_tracking_mpc import Controller, check_model, load_configuration
from uav_tracking_mpc.dynamics.vehicle import VehicleState
from uav_tracking_mpc.dynamics.vehicle_models import VEHICLE_MODEL
from uav_tracking_mpc.dynamics.vehicle_models.lagged import Lagged
from uav_tracking_mpc.parameters.conformance import ConformanceError

EXAMPLE = f"{Path(__file__).parents[3] / 'examples' / 'add_a_model.py'}:OneLag"


@pytest.mark.parametrize("name", [*VEHICLE_MODEL.own_names, EXAMPLE])
def test_the_models_of_the_project_and_the_example_pass(name):
    check_model(VEHICLE_MODEL.find(name))


def wrong(**members):
    """A model with these members."""
    return dataclass(frozen=True)(type("Wrong", (Lagged,), {"name": "wrong", **members}))


def other_way(self, state, inputs, duration, numbers, drift):
    return Lagged.step(self, state, [-inputs[0], inputs[1], inputs[2]], duration, numbers, drift)


def in_still_air(self, state, inputs, duration, numbers, drift):
    still = drift._replace(velocity=[0.0] * 3)
    return Lagged.step(self, state, inputs, duration, numbers, still)


def faster_as_symbol(self, state, inputs, duration, numbers, drift):
    after = Lagged.step(self, state, inputs, duration, numbers, drift)
    shift = 1.0 if isinstance(state.heading, ca.SX) else 0.0
    return after._replace(airspeed=after.airspeed + shift)


@pytest.mark.parametrize(
    ("members", "words"),
    [
        ({"State": VehicleState}, "wrong: State begins with .*, must begin with .*turn_rate"),
        ({"step": other_way}, "must be between rates and commands"),
        ({"step": in_still_air}, "wrong: the position moves with"),
        ({"step": faster_as_symbol}, "in numbers, .* in symbols"),
        ({"numbers": lambda *_: 1 / 0}, "wrong: ZeroDivisionError: division by zero"),
        ({"settled": lambda self, state, orbit: [state.turn_rate]}, "settled.. on an orbit"),
    ],
)
def test_what_is_wrong_is_said(members, words):
    with pytest.raises(ConformanceError, match=words):
        check_model(wrong(**members))


def test_a_controller_plans_with_a_model_of_ones_own():
    own = [f"nmpc_controller.vehicle_model={EXAMPLE}", "nmpc_controller.response_time=0.7"]
    parameters = load_configuration("small_uav", [*own, "nmpc_controller.solver=ipopt"]).controller
    np.testing.assert_array_equal(parameters.vehicle.lags, [0.7] * 3)
    formulation = Controller(parameters).formulation
    assert formulation is not None
    assert formulation.solver.problem.nx == 9
