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

"""The plant of six degrees of freedom: what it measures, its seed, its end, and a whole flight."""

import dataclasses
import math

import numpy as np
import pytest

from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_dynamics import RATE
from uav_tracking_mpc.simulation.plants import SimulationError
from uav_tracking_mpc.simulation.plants.jsbsim import JSBSimPlant
from uav_tracking_mpc.studies.comparison.measures import measures

PARAMETERS = SimulatorParameters(
    initial_position=(100.0, 50.0, 120.0), initial_heading=1.0, initial_path_angle=0.0,
    initial_speed=22.0, speed_max=30.0, speed_min=15.0, bank_max=0.8, wind=(3.0, -4.0, 0.0),
)  # fmt: skip


def turning(plant, duration=12.0, turn=0.25):
    plant.accept([[turn, 0.0, 0.0]] * 2, [plant.time, plant.time + duration])
    for _ in range(round(20 * duration)):
        plant.advance(0.05)
    return plant


def test_measured_are_the_motion_through_the_air_and_its_rates():
    plant = turning(JSBSimPlant(PARAMETERS))
    truth, fdm = plant.truth, plant.airframe._fdm
    east, north, up = truth.ground_velocity - plant.wind
    assert truth.airspeed == pytest.approx(math.sqrt(east**2 + north**2 + up**2), abs=1e-3)
    assert truth.airspeed == pytest.approx(0.3048 * fdm["velocities/vtrue-fps"], abs=1e-9)
    assert truth.path_angle == pytest.approx(math.asin(up / truth.airspeed), abs=2e-3)
    slip = fdm["aero/beta-rad"]
    off = math.remainder(truth.heading - math.atan2(north, east), 2 * math.pi)
    assert abs(off) < abs(slip) + 2e-3
    # The nose is elsewhere: past the path by the angle of attack times the sine of the bank.
    past = math.remainder(truth.heading - plant.airframe.yaw, 2 * math.pi)
    expected = fdm["aero/alpha-rad"] * math.sin(fdm["attitude/phi-rad"])
    assert past == pytest.approx(expected, rel=0.05)
    turned = truth.heading
    plant.advance(0.1)
    rate = math.remainder(plant.truth.heading - turned, 2 * math.pi) / 0.1
    assert truth.turn_rate == pytest.approx(rate, rel=0.02)
    assert truth.position[2] == pytest.approx(fdm["position/h-sl-meters"], abs=0.1)


def test_path_angle_rate_is_that_of_the_path_angle():
    plant = JSBSimPlant(PARAMETERS)
    plant.accept([[0.2, 0.2, 0.0]], [0.0])
    plant.advance(0.5)
    for _ in range(5):
        before = plant.truth
        plant.advance(0.05)
        after = plant.truth
        rate = (after.path_angle - before.path_angle) / 0.05
        mean = 0.5 * (after.path_angle_rate + before.path_angle_rate)
        assert mean == pytest.approx(rate, abs=0.02)


def test_flights_of_one_seed_are_the_same_and_of_another_are_not():
    gusty = dataclasses.replace(PARAMETERS, gust_intensity=15.0, seed=3)
    one, same, other = (
        turning(JSBSimPlant(dataclasses.replace(gusty, seed=seed)), 5.0) for seed in (3, 3, 4)
    )
    assert vars(one.truth).keys() == vars(same.truth).keys()
    for name, value in vars(one.truth).items():
        np.testing.assert_array_equal(vars(same.truth)[name], value)
    assert not np.array_equal(one.truth.position, other.truth.position)
    assert not np.array_equal(one.wind, PARAMETERS.wind)


def test_a_state_between_two_steps_is_where_the_aircraft_then_is():
    coarse, fine = JSBSimPlant(PARAMETERS), JSBSimPlant(PARAMETERS)
    fine.advance(0.1)
    for _ in range(30):
        coarse.advance(0.1 / 30)
    np.testing.assert_allclose(coarse.truth.position, fine.truth.position, atol=1e-6)
    coarse.advance(0.4 / RATE)
    assert coarse.truth.stamp == pytest.approx(0.1 + 0.4 / RATE)
    moved = coarse.truth.position - fine.truth.position
    np.testing.assert_allclose(moved, 0.4 / RATE * fine.truth.ground_velocity, atol=1e-4)


def test_what_the_plan_asks_for_is_flown_by_the_share_of_command_gain():
    weaker = JSBSimPlant(dataclasses.replace(PARAMETERS, command_gain=(0.5, 1.0, 1.0)))
    ratio = turning(weaker).truth.turn_rate / turning(JSBSimPlant(PARAMETERS)).truth.turn_rate
    assert ratio == pytest.approx(0.5, abs=0.01)


def test_the_ground_ends_the_flight():
    low = JSBSimPlant(dataclasses.replace(PARAMETERS, initial_position=(0.0, 0.0, 5.0)))
    low.accept([[0.0, -0.3, 0.0]], [0.0])
    with pytest.raises(SimulationError, match="hits the ground"):
        low.advance(10.0)


def test_a_start_that_cannot_be_flown_is_told():
    with pytest.raises(SimulationError, match="no steady flight at 8 m/s"):
        JSBSimPlant(dataclasses.replace(PARAMETERS, initial_speed=8.0, speed_min=5.0))


def test_the_controller_holds_its_orbit_and_nothing_is_printed(capfd):
    overrides = ["mission.duration=60.0", "nmpc_controller.solve_time_max=10.0"]
    configuration = load_configuration("jsbsim_uav", overrides, "still")
    flight = measures(simulate(configuration), configuration.controller)
    assert flight.range_rms_m < 0.1
    assert flight.altitude_rms_m < 0.3
    assert flight.settling_s is not None
    assert flight.settling_s < 20.0
    assert capfd.readouterr() == ("", "")
