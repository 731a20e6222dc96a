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

r"""Add a model of the vehicle: one time constant for all three rates.

The model is this one class: how it steps, for numbers and CasADi symbols alike. It is found by
``FILE.py:CLASS``::

    uav_tracking simulate --config small_uav \
        --set nmpc_controller.vehicle_model=examples/add_a_model.py:OneLag
"""

import math
import sys
from dataclasses import dataclass

import casadi as ca
import numpy as np

from uav_tracking_mpc import VehicleModel, VehicleState, check_model
from uav_tracking_mpc.cli.main import main
from uav_tracking_mpc.dynamics.vehicle import air_velocity
from uav_tracking_mpc.parameters.specification import parameter


@dataclass(frozen=True)
class OneLag(VehicleModel):
    """Turn rate, path-angle rate and acceleration follow commands with one time constant."""

    name = "one_lag"

    response_time: float = parameter(0.3, "Time constant of all three rates.", "s", 0.01, 5.0)

    def numbers(self, duration):
        """See :meth:`VehicleModel.numbers`: what is left of an error of the rates."""
        return np.array([math.exp(-duration / self.response_time)])

    @property
    def lags(self):
        """See :attr:`VehicleModel.lags`."""
        return np.full(3, self.response_time)

    def step(self, state, inputs, duration, numbers, drift):
        """See :meth:`VehicleModel.step`: the place by the midpoint rule."""
        xp = ca if isinstance(state.heading, ca.SX) else math
        rates = state[6:]
        later = [inputs[k] + (rates[k] - inputs[k]) * numbers[0] for k in range(3)]
        moved = [0.5 * duration * (rates[k] + later[k]) for k in range(3)]
        middle = air_velocity(*(state[3 + k] + 0.5 * moved[k] for k in range(3)), xp)
        place = [
            state[k] + duration * (middle[k] + drift.velocity[k] + 0.5 * duration * drift.rate[k])
            for k in range(3)
        ]
        return VehicleState(*place, *(state[3 + k] + moved[k] for k in range(3)), *later)


if __name__ == "__main__":
    check_model(OneLag)
    model = f"nmpc_controller.vehicle_model={__file__}:OneLag"
    sys.exit(main(["simulate", "--config", "small_uav", "--set", model, *sys.argv[1:]]))
