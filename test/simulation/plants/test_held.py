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

"""The plant whose autopilot holds altitude and airspeed."""

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.flown_orbit import FlownOrbit
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.plants.held import HeldPlant
from uav_tracking_mpc.simulation.plants.vehicle import VehiclePlant

FLIGHT = SimulatorParameters(
    initial_position=(400.0, 0.0, 100.0), initial_path_angle=0.0, initial_speed=20.0,
    speed_max=40.0, rate_lag=(0.3, 0.13, 0.16), pitch_rate_max=0.5, acceleration_min=-4.0,
    acceleration_max=5.0, yaw_rate_max=0.8,
)  # fmt: skip


def orbit(up=100.0, climb=0.0, airspeed=20.0):
    return FlownOrbit(np.array([0.0, 0.0, up]), np.array([3.0, 0.0, climb]), 200.0, airspeed)


def flown(plant, seconds):
    for _ in range(round(seconds / 0.05)):
        plant.advance(0.05)
    return plant.state


def test_it_flies_the_commanded_turn_and_ignores_the_rest():
    held, free = HeldPlant(FLIGHT), VehiclePlant(FLIGHT)
    held.accept([[0.2, 0.1, 2.0]], [0.0])
    free.accept([[0.2, 0.0, 0.0]], [0.0])
    np.testing.assert_allclose(flown(held, 0.9), flown(free, 0.9), atol=1e-9)


def test_altitude_and_airspeed_become_what_it_is_told():
    plant = HeldPlant(FLIGHT)
    plant.see_orbit(orbit(up=130.0, airspeed=23.0))
    _, _, height, _, path_angle, airspeed = flown(plant, 60.0)
    assert height == pytest.approx(130.0, abs=0.05)
    assert airspeed == pytest.approx(23.0, abs=0.01)
    assert path_angle == pytest.approx(0.0, abs=1e-3)


def test_the_altitude_goes_on_with_the_centre_when_nothing_more_is_heard():
    plant = HeldPlant(FLIGHT)
    plant.see_orbit(orbit(climb=0.5))
    _, _, height, *_ = flown(plant, 40.0)
    assert plant.altitude == pytest.approx(120.0)
    assert height == pytest.approx(120.0, abs=0.5)


def test_it_climbs_no_faster_than_it_can():
    plant = HeldPlant(FLIGHT)
    plant.see_orbit(orbit(up=300.0))
    flown(plant, 5.0)
    before = plant.state[2]
    assert flown(plant, 1.0)[2] - before == pytest.approx(5.0, abs=0.05)
