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

"""The inner loops on the aircraft that they are tuned for: steps, turns, limits, recovery."""

import dataclasses
import math

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.simulation.flight_control import ROLL_RATE_MAX
from uav_tracking_mpc.simulation.plants.jsbsim import JSBSimPlant

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


def test_climb_and_airspeed_follow_their_rates():
    plant = JSBSimPlant(LIMITS)
    seen = flown(plant, (0.0, 0.1, 0.0), 1.0)
    assert 0.06 < seen["path_angle"][-1] < 0.1
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
    assert abs(level.bank) < 0.01
    assert abs(level.path_angle) < 5e-3
    assert level.airspeed == pytest.approx(22.0, abs=0.2)
