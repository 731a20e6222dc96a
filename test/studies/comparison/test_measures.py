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

"""Closed forms: flights whose bank, force and errors are known."""

from dataclasses import replace

import numpy as np
import pytest
from example_flights import ORBIT, orbiting

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.report.metrics import flown_bank
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.studies.comparison.measures import measures, violations

LIMITS = TrackingParameters(airspeed_min=2.0, airspeed_max=8.0, bank_max=0.1, height_min=20.0)
STEADY = orbiting(301, step=0.1)


def with_vehicle(column, values, log=STEADY):
    vehicle = log.vehicle.copy()
    vehicle[:, column] = values
    return replace(log, vehicle=vehicle)


def test_a_perfect_orbit_has_no_error_and_breaks_no_limit():
    flight = measures(STEADY, LIMITS)
    for value in (flight.range_rms_m, flight.altitude_rms_m, flight.airspeed_rms_mps):
        assert value == pytest.approx(0.0, abs=1e-9)
    assert flight.bank_rate_rms_dps == pytest.approx(0.0, abs=1e-6)
    assert flight.settling_s == 0.0
    assert flight.envelope_violations == 0
    assert flight.violations == {}


def test_bank_of_the_steady_turn_is_that_of_its_centripetal_acceleration():
    bank = flown_bank(STEADY)
    assert len(bank) == len(STEADY.time) - 1
    expected = np.arctan(ORBIT.speed**2 / (GRAVITY * ORBIT.radius))  # clockwise: to the right
    np.testing.assert_allclose(bank, expected, rtol=1e-9)


def test_bank_rate_of_a_bank_that_swings():
    """tan(bank) = v psi' / g is small for psi' = 0.01 sin(w t): RMS v 0.01 w / (g sqrt 2)."""
    log, w = orbiting(6001, step=0.01), 2.0 * np.pi / 5.0
    log = with_vehicle(3, -0.01 / w * np.cos(w * log.time), log)
    expected = np.degrees(ORBIT.speed * 0.01 * w / GRAVITY / np.sqrt(2.0))
    assert measures(log, LIMITS).bank_rate_rms_dps == pytest.approx(expected, rel=1e-3)


def test_errors_count_over_the_last_third_and_settling_over_all():
    height = 50.0 + np.where(STEADY.time < 15.0, 40.0, 0.3)
    flight = measures(with_vehicle(2, height), LIMITS)
    assert flight.altitude_rms_m == pytest.approx(0.3)
    assert flight.settling_s == pytest.approx(15.0)
    never = measures(with_vehicle(2, np.full(301, 100.0)), LIMITS)
    assert never.settling_s is None


def test_what_counts_may_begin_earlier_or_later_and_commands_off_the_plan_are_counted():
    """Commands are sent at all samples but the last, from 0 to 29.9 s."""
    error = np.where(STEADY.time < 12.0, 8.0, 0.0)
    height = 50.0 + error
    nominal = np.ones(300, bool)
    nominal[[10, 119, 120, 250]] = False
    log = with_vehicle(2, height, replace(STEADY, nominal=nominal))
    assert measures(log, LIMITS, 12.0).altitude_rms_m == 0.0
    assert measures(log, LIMITS, 12.0).off_plan == 2
    assert measures(log, LIMITS, 11.9).worst_m > 0.0
    assert measures(log, LIMITS, 11.9).off_plan == 3
    assert measures(log, LIMITS).off_plan == 1
    assert measures(STEADY, LIMITS).off_plan is None


@pytest.mark.parametrize(
    ("column", "inside", "outside", "name"),
    [
        (5, 8.07, 8.09, "airspeed"),
        (5, 1.99, 1.97, "airspeed"),
        (4, 1.21, 1.22, "path angle"),
        (2, 19.9, 19.7, "height"),
    ],
)
def test_a_limit_may_be_passed_by_one_percent(column, inside, outside, name):
    values = STEADY.vehicle[:, column].copy()
    values[100:107] = inside
    assert not violations(with_vehicle(column, values), LIMITS)[name].any()
    values[100:107] = outside
    found = violations(with_vehicle(column, values), LIMITS)[name]
    assert list(np.flatnonzero(found)) == list(range(100, 107))


def test_distance_bank_force_and_fence():
    assert violations(STEADY, replace(LIMITS, distance_min=149.0))["distance"].sum() == 0
    assert violations(STEADY, replace(LIMITS, range=200.0, distance_min=152.0))["distance"].all()
    turning = with_vehicle(3, 0.3 * STEADY.time)  # bank 0.122
    assert violations(turning, LIMITS)["bank"].sum() == 300  # intervals
    climbing = with_vehicle(4, np.full(301, 0.25))  # force 2.43
    weak = replace(LIMITS, force_max=(2.0, 3.0))  # 2.33 at 4 m/s
    assert violations(climbing, weak)["force"].sum() == 300
    assert not violations(climbing, LIMITS)["force"].any()
    speeding = with_vehicle(5, 3.0 + 0.5 * STEADY.time, climbing)  # 0.5 m/s^2 more
    assert violations(speeding, replace(LIMITS, force_max=(2.89, 2.89)))["force"].sum() == 300
    assert not violations(speeding, replace(LIMITS, force_max=(2.93, 2.93)))["force"].any()
    assert not violations(STEADY, LIMITS)["fence"].any()
    fenced = replace(LIMITS, fence_radius=155.0, fence_centre=(-20.0, 0.0))
    assert 0 < violations(STEADY, fenced)["fence"].sum() < 301


def test_a_sample_beyond_two_limits_counts_once():
    log = with_vehicle(5, np.full(301, 9.0), with_vehicle(2, np.full(301, 10.0)))
    flight = measures(log, LIMITS)
    assert flight.violations["airspeed"] == flight.violations["height"] == 301
    assert flight.envelope_violations == 301


def test_what_is_no_number_is_no_value_inside_a_limit():
    values = STEADY.vehicle[:, 5].copy()
    values[7] = np.nan
    assert violations(with_vehicle(5, values), LIMITS)["airspeed"][7]
