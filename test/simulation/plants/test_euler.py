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

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.relative import error_dynamics, relative_state, steady_inputs
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import SimulationError, plant_of
from uav_tracking_mpc.simulation.plants.euler import EulerPlant


@pytest.mark.parametrize("model", ["exact", "paper", "paper9"])
def test_a_step_is_that_of_the_prediction(model, orbit):
    """(10), as the controller predicts with it, about a target that is not the origin."""
    target = np.array([30.0, -40.0, 5.0])
    start = SimulatorParameters(initial_position=(200.0, 60.0, 45.0), initial_speed=4.5)
    plant = EulerPlant(start, model, 1.0, target)
    error = relative_state(start.initial_state, target) - orbit.steady_state
    inputs = np.array([0.1, 0.02, -0.3])
    expected = error_dynamics(model, orbit, 1.0)(error, inputs - steady_inputs(model, orbit))
    plant.accept([inputs], [0.0])
    plant.advance(1.0)
    np.testing.assert_allclose(
        relative_state(plant.state, target) - orbit.steady_state,
        np.array(expected).ravel(),
        atol=1e-11,
    )


def test_a_mission_gives_it_model_step_and_target():
    configuration = load_configuration(
        "paper", ["nmpc_controller.horizon_step=0.5", "target_publisher.position=[9.0, 0.0, 0.0]"]
    )
    plant = plant_of(configuration)
    assert isinstance(plant, EulerPlant)
    assert plant.period == 0.5
    np.testing.assert_allclose(plant.truth.position, configuration.simulator.initial_position)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ("target_publisher.motion=line", "'motion' of target_publisher is 'line', must be 's"),
        ("uav_simulator.wind=[3, 0, 0]", r"'wind' of uav_simulator is \[3.0, 0.0, 0.0\], must be"),
        ("uav_simulator.gust_intensity=7.7", "'gust_intensity' of uav_simulator is 7.7, must be 0"),
        ("nmpc_controller.horizon_step=6", "'target_timeout' of .* is 5 s, must be .* 6 s"),
    ],
)
def test_what_it_cannot_fly_is_refused(told, words):
    with pytest.raises(SimulationError, match=words):
        plant_of(load_configuration("paper", [told]))


def test_straight_above_the_target_it_has_no_value():
    with pytest.raises(SimulationError, match="at 0 s the range is 20 m at a height of 20 m"):
        EulerPlant(SimulatorParameters(initial_position=(0.0, 0.0, 20.0)))
