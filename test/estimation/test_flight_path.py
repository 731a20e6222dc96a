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

"""Where the aircraft flies, from where its nose points."""

import dataclasses
import math

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.frames import (
    bank_from_turn_rate,
    rotation_from_quaternion,
    turn_rate_from_bank,
)
from uav_tracking_mpc.estimation.air_estimate import TURN_SLIP
from uav_tracking_mpc.estimation.flight_path import (
    CLIMB_LAG,
    QUICK_CLIMB,
    SLOW_CLIMB,
    SURPLUS_LIMIT,
    FlightDirection,
    FlightPath,
    past_nose,
)
from uav_tracking_mpc.estimation.measurement import Axis, Measurement

STEP, AIRSPEED = 0.02, 22.0
SLIPPING = 0.72  # -, of a coordinated turn's rate, as ArduPlane's simulated plane turns


def flown(direction, seconds, turn_rate, bank_rate, swing=lambda t: 0.0):
    """Fly; the true heading at the end, and the greatest errors of heading and rate meanwhile."""
    true, worst, worst_rate = 0.0, 0.0, 0.0
    for k in range(round(seconds / STEP)):
        time = k * STEP
        true = turn_rate * time
        direction.see(STEP if k else math.inf, true + swing(time), bank_rate)
        worst = max(worst, abs(direction.heading - true))
        worst_rate = max(worst_rate, abs(direction.rate - turn_rate))
    return true, worst, worst_rate


def body(time, bank, **changes):
    """In level flight to the East through still air, with an angle of attack of 0.1 rad."""
    measurement = Measurement(
        time, np.zeros(3), np.array([AIRSPEED, 0.0, 0.0]), 0.0, 0.1, 0.0, 0.0, AIRSPEED, bank=bank
    )
    return dataclasses.replace(measurement, **changes)


def test_a_coordinated_turn_is_told_as_it_is():
    _, heading, rate = flown(FlightDirection(), 60.0, 0.1, 0.1)
    assert heading < 1e-9
    assert rate < 1e-9


def test_the_nose_swings_and_the_flight_does_not():
    # 3 deg at 0.7 Hz, as ArduPlane's simulated plane swings: what is left of it is some tenths.
    amplitude, omega = math.radians(3.0), 2.0 * math.pi * 0.7
    swing = lambda t: amplitude * math.sin(omega * t)  # noqa: E731
    _, heading, rate = flown(FlightDirection(), 60.0, 0.1, 0.1, swing)
    assert heading < 0.3 * amplitude
    assert rate < 0.03 * amplitude * omega


@pytest.mark.parametrize("by_bank", [0.0, 0.02, -0.1, 0.4])
def test_a_turn_that_slips_is_learnt(by_bank):
    direction, rate = FlightDirection(), 0.01 + SLIPPING * by_bank
    true, _, _ = flown(direction, 60.0, rate, by_bank)
    assert direction.surplus == pytest.approx(rate - by_bank, abs=1e-4)
    assert direction.rate == pytest.approx(rate, abs=1e-4)
    assert direction.heading == pytest.approx(true, abs=1e-3)


def test_what_a_turn_has_told_counts_soon_in_the_next_one():
    direction = FlightDirection()
    flown(direction, 60.0, 0.4 * SLIPPING, 0.4)
    flown(direction, 5.0, -0.4 * SLIPPING, -0.4)
    assert direction.rate == pytest.approx(-0.4 * SLIPPING, abs=0.02)


def test_in_a_quick_roll_the_bank_counts_in_full():
    direction = FlightDirection()
    flown(direction, 60.0, 0.2 * SLIPPING, 0.2)
    before, bank_rates = direction.rate, (0.3, 0.1) * 5
    for k, bank_rate in enumerate(bank_rates):
        direction.see(STEP, 0.2 * SLIPPING * (60.0 + STEP * k), bank_rate)
        assert direction.rate - before == pytest.approx(bank_rate - 0.2, abs=0.005)


def test_a_broken_compass_is_not_flown_by_without_end():
    direction = FlightDirection()
    flown(direction, 60.0, 3.0, 0.1)
    assert abs(direction.surplus) <= SURPLUS_LIMIT


@pytest.mark.parametrize("lead", [0.0, 0.7, 1.5])
def test_gusts_that_swing_the_nose_tell_nothing_of_the_airspeed(lead):
    # 2 m/s across the flight; meanwhile the aircraft rolls against them.
    path, true, least = FlightPath(), 0.0, 1.0
    for k in range(1500):
        phase = 0.5 * 0.05 * k
        rate, swing = 0.1 + 0.06 * math.sin(phase + lead), 0.1 * math.sin(phase)
        true += 0.05 * rate
        path.of(body(0.05 * k, bank_from_turn_rate(rate, AIRSPEED), heading=true + swing), AIRSPEED)
        least = min(least, path.airspeed_share)
    assert least > 1.0 - TURN_SLIP


def test_a_turn_that_is_too_quick_for_its_bank_tells_of_the_airspeed():
    path = FlightPath()
    for k in range(1000):
        bank = bank_from_turn_rate(0.1, 17.0)
        path.of(body(0.05 * k, bank, heading=0.1 * 0.05 * k), AIRSPEED)
    assert path.airspeed_share == pytest.approx(17.0 / AIRSPEED, rel=0.1)


@pytest.mark.parametrize("bank", [-0.9, -0.3, 0.0, 0.6, 1.2])
@pytest.mark.parametrize("alpha", [-0.05, 0.08, 0.2])
def test_the_air_velocity_without_sideslip_is_found_from_the_attitude(bank, alpha):
    # In body axes (forward, left, up) it lies in the plane of symmetry, alpha below the nose.
    pitch, yaw = 0.15, 0.7
    (sr, cr), (sp, cp), (sy, cy) = (
        (math.sin(0.5 * a), math.cos(0.5 * a)) for a in (bank, -pitch, yaw)
    )
    rotation = rotation_from_quaternion(
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
    east, north, up = rotation @ [math.cos(alpha), 0.0, -math.sin(alpha)]
    found = yaw + past_nose(bank, pitch, math.asin(up))
    assert found == pytest.approx(math.atan2(north, east), abs=1e-9)


def test_a_bank_tells_the_turn_and_the_climb_tells_the_path_angle():
    path, bank = FlightPath(), 0.5
    seen = path.of(body(0.0, bank, turn_rate=0.9, path_angle_rate=-0.4), AIRSPEED)
    assert seen.axis is Axis.AIR_VELOCITY
    assert seen.turn_rate == pytest.approx(turn_rate_from_bank(bank, AIRSPEED))
    assert seen.path_angle == seen.path_angle_rate == 0.0
    assert seen.heading == pytest.approx(past_nose(bank, 0.1, 0.0))
    assert path.of(seen, AIRSPEED) is seen
    again = path.of(body(0.0, bank), AIRSPEED)  # the same once more changes nothing
    assert (again.heading, again.path_angle) == (seen.heading, seen.path_angle)


@pytest.mark.parametrize("changes", [{"bank": None}, {"bank": 1.55}, {"path_angle": 1.55}])
def test_a_body_of_which_too_little_is_known_is_taken_to_fly_where_it_points(changes):
    measurement = dataclasses.replace(body(0.0, 0.3), **changes)
    assert FlightPath().of(measurement, AIRSPEED) is measurement
    assert FlightPath().of(body(0.0, 0.3), 2.0).axis is Axis.BODY


@pytest.mark.parametrize("frequency", [QUICK_CLIMB, SLOW_CLIMB])
def test_a_climb_that_grows_is_followed_without_an_error(frequency):
    path, rate = FlightPath(), 0.5
    for k in range(1000):
        velocity = np.array([AIRSPEED, 0.0, rate * k * STEP])
        seen = path.of(body(k * STEP, 0.0, ground_velocity=velocity), AIRSPEED, frequency)
    assert AIRSPEED * math.sin(seen.path_angle) == pytest.approx(velocity[2], abs=0.02)
    assert seen.path_angle_rate == pytest.approx(rate / AIRSPEED, rel=5e-3)


@pytest.mark.parametrize("turn_rate", [0.07, 0.3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bank_of_the_wrong_sign_is_left_out(turn_rate, sign):
    path, right = FlightPath(), bank_from_turn_rate(turn_rate, AIRSPEED)
    for k in range(2000):
        time, bank = k * STEP, sign * right * min(k * STEP, 1.0)
        heading = math.remainder(turn_rate * time, 2.0 * math.pi)
        seen = path.of(body(time, bank, heading=heading), AIRSPEED)
    assert path.contradicted is (seen.axis is Axis.BODY) is (sign < 0.0)


def test_quick_rolls_that_the_nose_does_not_follow_contradict_nothing():
    # 20 deg at 0.8 Hz, as ArduPlane's simulated plane rolls in turbulence.
    path = FlightPath()
    for k in range(3000):
        path.of(body(STEP * k, math.radians(20.0) * math.sin(5.0 * STEP * k)), AIRSPEED)
    assert not path.contradicted


def test_without_a_ground_velocity_pitch_and_height_tell_the_climb():
    """One of the wrong sign would have the aircraft climb when it sinks, and flown into the ground.

    The angle of attack is 0.1 rad, in air that begins to rise meanwhile; the path follows the nose.
    """
    path, height, worst = FlightPath(), 0.0, 0.0
    for k in range(round(60.0 / STEP)):
        time = k * STEP
        flown = 0.15 * math.sin(0.5 * time)
        nose = flown + 0.1 + CLIMB_LAG * 0.075 * math.cos(0.5 * time)
        climb = AIRSPEED * math.sin(flown) + (0.5 if time > 30.0 else 0.0)
        height += STEP * climb
        failed = time > 20.0
        up = -climb if failed else climb
        position = np.array([0.0, 0.0, math.nan if 40.0 < time < 45.0 else height])
        if math.isnan(position[2]):
            position[:] = math.nan
        velocity = np.array([AIRSPEED, 0.0, up])
        seen = body(time, 0.0, position=position, ground_velocity=velocity, path_angle=nose)
        error = AIRSPEED * path.of(seen, AIRSPEED, velocity_failed=failed).path_angle - climb
        if time > 1.0:
            worst = max(worst, abs(error))
    assert worst < 0.6
    assert abs(error) < 0.05


@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_an_aircraft_that_is_steered_by_a_climb_of_the_other_sign_is_caught(noise):
    """Its nose is steered against the climb that is told; from 60 to 90 s its sign is wrong.

    Before that the height is for some time measured 20 m too high, which is none of the climb's.
    """
    path, rng, failed, climbs = FlightPath(), np.random.default_rng(2), [], []
    nose, climb, height = 0.1, 0.0, 100.0
    for k in range(round(150.0 / STEP)):
        time = k * STEP
        gust = 0.8 * math.sin(0.9 * time) + 0.5 * math.sin(0.31 * time)
        rising = AIRSPEED * (nose - 0.1) + gust
        climb += (1.0 - math.exp(-STEP / CLIMB_LAG)) * (rising - climb)
        height += STEP * climb
        up = -climb if 60.0 < time < 90.0 else climb
        velocity = np.array([AIRSPEED, 0.0, up])
        told = height + noise * rng.normal() + (20.0 if 30.0 < time < 40.0 else 0.0)
        position = np.array([0.0, 0.0, told])
        seen = body(time, 1e-3, position=position, ground_velocity=velocity, path_angle=nose)
        nose -= STEP * 2.5 * path.of(seen, AIRSPEED).path_angle
        failed.append(path.climb.failed)
        climbs.append(abs(climb))
    failed, climbs = np.reshape(failed, (15, -1)), np.reshape(climbs, (15, -1)).max(axis=1)
    assert not failed[:6].any()
    assert failed[7:9].all()
    assert not failed[12:].any()
    assert climbs[6] < 8.0
    assert climbs[[7, 8, *range(9, 15)]].max() < 2.0


@pytest.mark.parametrize("error", [-3.0, 0.0, 3.0])
def test_a_climb_that_leads_elsewhere_for_long_is_wrong(error):
    """By 3 m/s: no more than gusts make of it for a while."""
    path, rng, height = FlightPath(), np.random.default_rng(1), 100.0
    for k in range(round(60.0 / STEP)):
        gust = 1.0 * math.sin(0.9 * k * STEP) + 0.5 * math.sin(0.31 * k * STEP)
        height += STEP * gust
        velocity = np.array([AIRSPEED, 0.0, gust + (error if k * STEP > 30.0 else 0.0)])
        position = np.array([0.0, 0.0, height + 0.3 * rng.normal()])
        seen = body(k * STEP, 1e-3, position=position, ground_velocity=velocity, path_angle=0.1)
        path.of(seen, AIRSPEED, height_noise=0.3)
        assert not path.climb.failed or k * STEP > 30.0
    assert path.climb.failed == (error != 0.0)


def test_a_bank_that_changes_its_sign_tells_nothing_of_the_airspeed():
    path, least = FlightPath(), 1.0
    for k in range(1000):
        bank = bank_from_turn_rate(0.1 if k < 600 else -0.1, AIRSPEED)
        path.of(body(0.05 * k, bank, heading=0.1 * 0.05 * k), AIRSPEED)
        least = min(least, path.airspeed_share)
    assert path.contradicted
    assert least > 1.0 - TURN_SLIP


def test_a_heading_that_is_known_to_be_wrong_neither_turns_the_flight_nor_contradicts_the_bank():
    path, bank = FlightPath(), bank_from_turn_rate(0.1, AIRSPEED)
    for k in range(1200):
        heading = 0.1 * 0.05 * k * (1.0 if k < 200 else -1.0)
        seen = body(0.05 * k, bank, heading=heading, path_angle=0.0)
        told = path.of(seen, AIRSPEED, heading_failed=k > 200)
    assert not path.contradicted
    assert told.turn_rate == pytest.approx(0.1, abs=0.01)
    # Whether it is right again shows where the compass points.
    assert math.remainder(told.heading - heading, math.tau) == pytest.approx(0.0, abs=0.01)


def test_while_the_heading_is_stuck_the_bank_alone_turns_the_flight():
    """And where it then points is for others to judge."""
    path, turn_rate = FlightPath(), 0.1
    bank, past = bank_from_turn_rate(turn_rate, AIRSPEED), None
    for k in range(4000):
        time = k * STEP
        stuck = 22.0 < time < 50.0
        heading = turn_rate * (20.0 if 20.0 < time < 50.0 else time)
        seen = path.of(body(time, bank, heading=heading), AIRSPEED, heading_stuck=stuck)
        past = past or seen.heading
        off = math.remainder(seen.heading - past - turn_rate * time, 2.0 * math.pi)
        assert abs(off) < (0.6 if 20.0 < time < 65.0 else 0.05)
        assert seen.turn_rate == pytest.approx(turn_rate, abs=0.015)
