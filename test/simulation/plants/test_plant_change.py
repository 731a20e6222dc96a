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

"""Every plant takes other air and sensors in flight, or says in words that it cannot."""

from dataclasses import replace

import numpy as np
import pytest

from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants import Plant
from uav_tracking_mpc.simulation.plants.euler import EulerPlant
from uav_tracking_mpc.simulation.plants.jsbsim import JSBSimPlant
from uav_tracking_mpc.simulation.plants.vehicle import HeldPlant, VehiclePlant

PARAMETERS = SimulatorParameters(
    initial_position=(400.0, 0.0, 120.0), initial_heading=1.0, initial_path_angle=0.0,
    initial_speed=22.0, speed_max=40.0, bank_max=0.8,
)  # fmt: skip


class Outside(Plant):
    """What knows nothing of changes: it moves straight on."""

    name = "outside"

    def advance(self, duration):
        self.time += duration

    @property
    def truth(self):
        return replace(VehiclePlant(self.parameters).truth, stamp=self.time)


ALL = (VehiclePlant, HeldPlant, JSBSimPlant, EulerPlant, Outside)


@pytest.mark.parametrize("kind", [VehiclePlant, HeldPlant, JSBSimPlant])
def test_other_wind_carries_it_away_without_a_jump(kind):
    plant, still = kind(PARAMETERS), kind(PARAMETERS)
    plant.advance(0.5)
    still.advance(0.5)
    before = plant.truth.position
    plant.change(replace(PARAMETERS, wind=(3.0, -4.0, 0.0)))
    np.testing.assert_allclose(plant.truth.position, before, atol=1e-9)
    for _ in range(20):
        plant.advance(0.05)
        still.advance(0.05)
        np.testing.assert_allclose(plant.wind, [3.0, -4.0, 0.0], atol=1e-6)
    drifted = plant.truth.position - still.truth.position
    if kind is JSBSimPlant:  # it has mass: the wind takes it along by and by
        assert drifted[0] > 0.1 and drifted[1] < -0.1
    else:
        np.testing.assert_allclose(drifted, [3.0, -4.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("kind", [VehiclePlant, HeldPlant, JSBSimPlant])
def test_gusts_begin_and_end(kind):
    plant = kind(PARAMETERS)

    def spread():
        winds = []
        for _ in range(200):
            plant.advance(0.05)
            winds.append(plant.wind)
        return np.std(winds, axis=0).max()

    assert spread() < 1e-9
    plant.change(replace(PARAMETERS, gust_intensity=8.0))
    assert spread() > 0.1
    plant.change(PARAMETERS)
    for _ in range(600):  # what is in the filters dies away
        plant.advance(0.05)
    assert spread() < 0.01


@pytest.mark.parametrize("kind", ALL)
def test_sensors_become_noisy_and_true_again(kind):
    plant = kind(PARAMETERS)
    plant.change(replace(PARAMETERS, position_noise=2.0, heading_bias=0.1, speed=3.0))
    first, second = plant.measured(), plant.measured()
    assert not np.array_equal(first.position, second.position)
    assert first.heading == pytest.approx(plant.aboard.heading + 0.1)
    plant.change(PARAMETERS)
    np.testing.assert_array_equal(plant.measured().position, plant.truth.position)


@pytest.mark.parametrize("kind", ALL)
@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"seed": 3}, "'seed' is 3, must stay 0 while the simulator runs"),
        ({"initial_speed": 21.0}, "'initial_speed' is 21.0, must stay 22.0 while"),
        ({"hold_climb_max": 1.0}, "cannot change it in flight"),
    ],
)
def test_what_stays_is_told_and_nothing_is_half_applied(kind, values, words):
    plant = kind(PARAMETERS)
    with pytest.raises(ParameterError, match=words):
        plant.change(replace(PARAMETERS, position_noise=2.0, **values))
    assert plant.parameters is PARAMETERS
    np.testing.assert_array_equal(plant.measured().position, plant.truth.position)


@pytest.mark.parametrize("kind", [EulerPlant, Outside])
def test_a_plant_without_air_to_change_says_so(kind):
    plant = kind(PARAMETERS)
    with pytest.raises(ParameterError, match=f"the plant '{kind.name}' cannot change it in flight"):
        plant.change(replace(PARAMETERS, wind=(1.0, 0.0, 0.0)))
