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

import math

import pytest

from uav_tracking_mpc.links.mavlink.flight_direction import SURPLUS_LIMIT, FlightDirection

STEP = 0.02


def flown(direction, seconds, turn_rate, bank_rate, swing=lambda t: 0.0, swing_rate=lambda t: 0.0):
    """Fly; the true heading at the end, and the greatest errors of heading and rate meanwhile."""
    true, worst, worst_rate = 0.0, 0.0, 0.0
    for k in range(round(seconds / STEP)):
        time = k * STEP
        true = turn_rate * time
        direction.see(time, true + swing(time), turn_rate + swing_rate(time), bank_rate)
        worst = max(worst, abs(direction.heading - true))
        worst_rate = max(worst_rate, abs(direction.rate - turn_rate))
    return true, worst, worst_rate


def test_a_coordinated_turn_is_told_as_it_is():
    direction = FlightDirection()
    _, heading, rate = flown(direction, 60.0, 0.1, 0.1)
    assert heading < 1e-9
    assert rate < 1e-9


def test_the_nose_swings_and_the_flight_does_not():
    # 3 deg at 0.7 Hz, as ArduPlane's simulated plane swings: what is left of it is some tenths.
    amplitude, omega = math.radians(3.0), 2.0 * math.pi * 0.7
    direction = FlightDirection()
    _, heading, rate = flown(
        direction,
        60.0,
        0.1,
        0.1,
        lambda t: amplitude * math.sin(omega * t),
        lambda t: amplitude * omega * math.cos(omega * t),
    )
    first_surplus = amplitude * omega  # the filter begins in the middle of a swing
    assert rate < 1.1 * first_surplus
    late = FlightDirection()
    flown(late, 60.0, 0.1, 0.1, lambda t: amplitude * (1.0 - math.cos(omega * t)))
    assert abs(late.rate - 0.1) < 0.2 * first_surplus
    assert heading < 4.0 * amplitude


def test_a_turn_that_slips_is_learnt():
    direction = FlightDirection()
    direction.see(0.0, 0.0, 0.0, 0.0)
    rate, by_bank = 0.072, 0.1
    for k in range(1, round(60.0 / STEP)):
        direction.see(k * STEP, rate * k * STEP, rate, by_bank)
    assert direction.surplus == pytest.approx(rate - by_bank, abs=1e-4)
    assert direction.rate == pytest.approx(rate, abs=1e-4)
    assert direction.heading == pytest.approx(rate * (k * STEP), abs=1e-3)


def test_a_broken_gyro_is_not_flown_by_without_end():
    direction = FlightDirection()
    flown(direction, 60.0, 3.0, 0.1)
    assert abs(direction.surplus) <= SURPLUS_LIMIT


def test_without_an_airspeed_the_nose_counts():
    direction = FlightDirection()
    flown(direction, 10.0, 0.07, 0.1)
    direction.see(10.0, 1.0, 0.2, None)
    assert (direction.heading, direction.rate, direction.surplus) == (1.0, 0.2, 0.0)
