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

"""The plant of six degrees of freedom: its inner loops, what it measures, a whole flight."""

import dataclasses
import math

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_dynamics import RATE
from uav_tracking_mpc.simulation.plants import SimulationError
from uav_tracking_mpc.simulation.plants.jsbsim import ROLL_RATE_MAX, JSBSimPlant
from uav_tracking_mpc.studies.comparison.measures import measures

LIMITS = SimulatorParameters(
    initial_position=(0.0, 0.0, 200.0), initial_path_angle=0.0, initial_speed=22.0,
    yaw_rate_max=1.0, pitch_rate_max=0.5, acceleration_min=-4.0, acceleration_max=5.0,
    speed_min=15.0, speed_max=30.0, bank_max=math.radians(45.0),
)  # fmt: skip
TICK = 0.05


def flown(plant, inputs, duration):
    """What the autopilot measures after each tick with constant inputs, by name, as arrays."""
    seen = []
    for _ in range(round(duration / TICK)):
        plant.accept([inputs], [plant.time])
        plant.advance(TICK)
        seen.append(plant.airframe.flown)
    return {name: np.array([getattr(each, name) for each in seen]) for name in seen[0]._fields}


@pytest.mark.parametrize("bank", [-30.0, 15.0, 40.0])
def test_bank_follows_a_step_within_half_a_second_and_hardly_beyond(bank):
    turn = -GRAVITY * math.tan(math.radians(bank)) / 22.0  # positive to the left
    seen = flown(JSBSimPlant(LIMITS), (turn, 0.0, 0.0), 5.0)
    share = np.degrees(seen["bank"]) / bank
    reached = TICK * (1 + np.argmax(share > 1.0 - math.exp(-1.0)))
    assert 0.25 < reached < 0.75
    assert share.max() < 1.03
    assert share[-1] == pytest.approx(1.0, abs=0.01)
    assert np.abs(seen["roll_rate"]).max() < 1.1 * ROLL_RATE_MAX
    assert abs(seen["side_force"][-1]) < 0.2


def test_turn_is_coordinated_and_keeps_height_and_airspeed():
    plant = JSBSimPlant(LIMITS)
    flown(plant, (0.3, 0.0, 0.0), 20.0)
    before = plant.truth
    seen = flown(plant, (0.3, 0.0, 0.0), 10.0)
    after = plant.truth
    turned = math.remainder(after.heading - before.heading - 3.0, 2.0 * math.pi)
    assert abs(turned) < 0.05
    assert abs(after.position[2] - 200.0) < 2.0
    np.testing.assert_allclose(seen["airspeed"], 22.0, atol=0.15)
    np.testing.assert_allclose(seen["side_force"], 0.0, atol=0.1)
    # L cos(bank) = m g
    np.testing.assert_allclose(seen["lift"] * np.cos(seen["bank"]), GRAVITY, rtol=0.02)


def test_a_turn_in_a_climb_has_the_bank_of_a_level_one():
    """Both parts of the lift grow with cos(chi), which the turn rate takes out again."""
    plant = JSBSimPlant(LIMITS)
    flown(plant, (0.3, 0.12, 0.0), 2.0)
    seen = flown(plant, (0.3, 0.0, 0.0), 4.0)
    assert seen["path_angle"][-1] == pytest.approx(0.24, abs=0.02)
    wanted = -0.3 * seen["airspeed"][-1] / GRAVITY
    assert math.tan(plant.control.bank_demand) == pytest.approx(wanted, rel=2e-3)


def test_climb_and_airspeed_follow_their_rates():
    plant = JSBSimPlant(LIMITS)
    assert 0.06 < flown(plant, (0.0, 0.1, 0.0), 1.0)["path_angle"][-1] < 0.1
    seen = flown(plant, (0.0, 0.0, 0.0), 6.0)
    assert seen["path_angle"].max() < 0.108
    assert seen["path_angle"][-1] == pytest.approx(0.1, abs=5e-3)
    flown(plant, (0.0, -0.1, 0.0), 1.0)
    flown(plant, (0.0, 0.0, 1.0), 2.0)
    seen = flown(plant, (0.0, 0.0, 0.0), 6.0)
    assert seen["airspeed"].max() < 24.4
    assert seen["airspeed"][-1] == pytest.approx(24.0, abs=0.15)


def test_limits_of_bank_and_airspeed_hold():
    plant = JSBSimPlant(LIMITS)
    seen = flown(plant, (3.0, 0.0, 0.0), 8.0)
    assert np.degrees(seen["bank"]).min() > -46.5
    assert plant.control.bank_demand == pytest.approx(-LIMITS.bank_max)
    plant = JSBSimPlant(dataclasses.replace(LIMITS, speed_max=25.0))
    assert flown(plant, (0.0, 0.0, 5.0), 15.0)["airspeed"].max() < 25.3
    plant = JSBSimPlant(dataclasses.replace(LIMITS, speed_min=18.0))
    assert flown(plant, (0.0, 0.0, -4.0), 15.0)["airspeed"].min() > 17.3


def test_after_too_steep_a_climb_the_throttle_is_free_again_at_once():
    plant = JSBSimPlant(dataclasses.replace(LIMITS, speed_min=19.0))
    flown(plant, (0.0, 0.2, 0.0), 2.0)
    seen = flown(plant, (0.0, 0.0, 0.0), 6.0)  # 0.4 rad: more than the engine bears
    assert seen["airspeed"].min() < 21.0
    flown(plant, (0.0, -0.2, 0.0), 2.0)
    seen = flown(plant, (0.0, 0.0, 0.0), 10.0)
    assert seen["airspeed"].max() < 23.5
    assert seen["airspeed"][-1] == pytest.approx(22.0, abs=0.3)


def test_without_a_plan_wings_and_climb_are_levelled():
    plant = JSBSimPlant(LIMITS)
    flown(plant, (0.3, 0.1, 0.0), 1.0)
    plant.advance(10.0)
    level = plant.airframe.flown
    off = np.abs([level.bank, level.path_angle, level.airspeed - 22.0])
    np.testing.assert_array_less(off, [0.01, 5e-3, 0.2])


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
    overrides = ["mission.duration=45.0", "nmpc_controller.solve_time_max=10.0"]
    configuration = load_configuration("jsbsim_uav", overrides, "still")
    flight = measures(simulate(configuration), configuration.controller)
    assert flight.settling_s is not None
    found = flight.range_rms_m, flight.altitude_rms_m, flight.settling_s
    np.testing.assert_array_less(found, [0.1, 0.3, 20.0])
    assert capfd.readouterr() == ("", "")
