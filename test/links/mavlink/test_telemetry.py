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

"""Messages to measurements by our clock: units, frames, times, restarts, and what is dropped."""

import math

import numpy as np
import pytest

from uav_tracking_mpc.dynamics.air import true_over_equivalent
from uav_tracking_mpc.dynamics.geodesy import LocalFrame
from uav_tracking_mpc.estimation.measurement import SILENT, Axis
from uav_tracking_mpc.links.mavlink.dialect import mavlink
from uav_tracking_mpc.links.mavlink.telemetry import (
    AGE,
    AIRSPEED_SENSOR,
    Accuracies,
    AutopilotClock,
    Telemetry,
)

HOME = LocalFrame(math.radians(47.3977), math.radians(8.5456), 488.0)


def telemetry(origin=None):
    clock = AutopilotClock()
    clock.see_answer(0.0, 100.0, 0.0)  # 100 s ahead of ours
    return Telemetry(clock, origin)


def home(latitude=47.3977):
    longitude = math.degrees(HOME.longitude)
    return mavlink.MAVLink_home_position_message(
        round(latitude * 1e7), round(longitude * 1e7), 488000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0
    )


def position(time, at, velocity=(0, 0, 0)):
    latitude, longitude, altitude = HOME.place(at)
    east, north, up = velocity
    return mavlink.MAVLink_global_position_int_message(
        round(time * 1e3),
        round(math.degrees(latitude) * 1e7),
        round(math.degrees(longitude) * 1e7),
        round(altitude * 1e3),
        0,
        round(north * 1e2),
        round(east * 1e2),
        round(-up * 1e2),
        0,
    )


def attitude(time, roll=0.0, pitch=0.0, yaw=0.0, rates=(0.0, 0.0, 0.0)):
    return mavlink.MAVLink_attitude_message(round(time * 1e3), roll, pitch, yaw, *rates)


def hud(airspeed):
    return mavlink.MAVLink_vfr_hud_message(airspeed, 20.0, 0, 50, 600.0, 0.0)


def flown(heard, *messages, arrival=1.0):
    measured = None
    for message in messages:
        measured = heard.see(message, arrival) or measured
    return measured


def test_a_measurement_says_how_accurate_it_is():
    status = mavlink.MAVLink_estimator_status_message(0, 63, *([0.1] * 6), 0.5, 0.8)
    heard = telemetry()
    seen = flown(
        heard, home(), hud(20.0), status, attitude(101.0), position(101.0, (0.0, 0.0, 99.0))
    )
    assert seen.noise.position == pytest.approx((0.5, 0.5, 0.8))
    heard.forget()  # another boot
    seen = flown(heard, hud(20.0), attitude(1.0), position(1.0, (0.0, 0.0, 99.0)))
    assert seen.noise.position == (0.0, 0.0, 0.0)


def test_a_measurement_is_complete_and_in_our_axes():
    heard, yaw, turn = telemetry(), math.radians(30.0), 0.2
    where, velocity = (300.0, -120.0, 150.0), (11.0, 19.0, 2.0)
    seen = flown(
        heard,
        home(),
        hud(20.0),
        attitude(101.0, 0.3, 0.1, yaw, (0.0, 0.0, 0.0)),
        attitude(101.0, 0.0, 0.05, yaw, (0.5, 0.1, -turn * math.cos(0.05))),
        position(101.0, where, velocity),
    )
    true = 20.0 * true_over_equivalent(488.0 + 150.0)
    assert seen.stamp == pytest.approx(1.0)
    np.testing.assert_allclose(seen.position, where, atol=0.02)
    np.testing.assert_allclose(seen.ground_velocity, velocity, atol=0.006)
    assert seen.heading == pytest.approx(math.radians(60.0))
    assert seen.airspeed == pytest.approx(true, rel=1e-4)
    assert seen.axis is Axis.BODY
    assert (seen.bank, seen.path_angle) == pytest.approx((0.0, 0.05))
    assert (seen.turn_rate, seen.path_angle_rate) == pytest.approx((turn, 0.1))


def test_the_heading_is_carried_on_to_the_positions_time():
    seen = flown(
        telemetry(), home(), attitude(101.0, rates=(0.0, 0.0, -0.5)), position(101.1, (0, 0, 100))
    )
    assert seen.heading == pytest.approx(0.5 * math.pi + 0.05, abs=1e-4)


def test_a_position_before_the_filter_has_an_origin_is_none():
    heard = telemetry(HOME)
    nowhere = mavlink.MAVLink_global_position_int_message(101000, 12, -7, 0, 0, 0, 0, 0, 0)
    assert flown(heard, attitude(101.0), nowhere) is None
    assert flown(heard, attitude(101.1), position(101.1, (9.0, 0.0, 100.0))) is not None


def test_another_origin_may_be_stated():
    origin = LocalFrame(*HOME.place((1000.0, 2000.0, 0.0)))
    seen = flown(
        telemetry(origin), home(), attitude(101.0), position(101.0, (1000.0, 2000.0, 50.0))
    )
    np.testing.assert_allclose(seen.position, (0.0, 0.0, 50.0), atol=0.02)


def sensors(*, enabled=AIRSPEED_SENSOR, health=AIRSPEED_SENSOR):
    return mavlink.MAVLink_sys_status_message(
        AIRSPEED_SENSOR, enabled, health, 200, 16000, -1, 100, 0, 0, 0, 0, 0, 0
    )


@pytest.mark.parametrize("fault", ["enabled", "health"])
def test_an_airspeed_that_the_autopilot_does_not_use_is_not_used_here(fault):
    # ArduPlane disables a sensor that is stuck, and goes on to tell its value.
    heard, where, velocity = telemetry(), (0.0, 0.0, 100.0), (22.0, 8.0, 0.0)
    flown(heard, home(), hud(20.0), attitude(101.0), position(101.0, where, velocity))
    heard.see(sensors(**{fault: 0}), 1.0)
    assert flown(heard, hud(5.0), attitude(102.0), position(102.0, where)).airspeed is None
    heard.see(mavlink.MAVLink_wind_message(180.0, 8.0, 0.0), 1.0)
    flown(heard, attitude(103.0), position(103.0, where, velocity))
    assert heard.airspeed == pytest.approx(22.0)
    heard.see(sensors(), 1.0)
    assert heard.airspeed == pytest.approx(5.0, rel=0.1)


def test_without_air_data_or_with_old_ones_there_is_no_airspeed():
    heard = telemetry()
    assert flown(heard, home(), attitude(101.0), position(101.0, (0, 0, 100))).airspeed is None
    flown(heard, hud(20.0), arrival=1.0)
    seen = flown(heard, attitude(103.0), position(103.0, (0, 0, 100)), arrival=3.0)
    assert seen.airspeed is None


@pytest.mark.parametrize(
    "messages",
    [
        (attitude(101.0), position(101.0, (0, 0, 100))),  # nothing says where map is
        (home(), position(101.0, (0, 0, 100))),
        (home(), attitude(100.0), position(101.0, (0, 0, 100))),  # too far apart
        (home(), attitude(101.0, math.nan), position(101.0, (0, 0, 100))),
        (
            home(),
            attitude(101.0),
            mavlink.MAVLink_global_position_int_message(101000, 0, 0, 0, 0, 0, 0, 0, 0),
        ),
    ],
)
def test_what_is_missing_or_nonsense_makes_no_measurement(messages):
    assert flown(telemetry(), *messages) is None


@pytest.mark.parametrize("wrong", [math.nan, math.inf])
def test_a_wind_from_nowhere_and_a_home_that_is_no_place_on_earth_are_left_out(wrong):
    heard = telemetry()
    flown(heard, home(200.0), home(), home(200.0), mavlink.MAVLink_wind_message(wrong, 8.0, 0.0))
    assert heard.wind is None
    assert heard.home.latitude == heard.frame.latitude == pytest.approx(HOME.latitude)


def test_a_repeated_or_overtaken_position_makes_no_measurement():
    heard = telemetry()
    assert flown(heard, home(), attitude(101.0), position(101.0, (0, 0, 100))) is not None
    assert flown(heard, position(101.0, (0, 0, 100))) is None
    assert flown(heard, position(100.9, (0, 0, 100))) is None


def test_an_overtaken_attitude_does_not_come_in_place_of_the_later_one():
    heard = telemetry(HOME)
    flown(heard, attitude(101.0, roll=0.3), attitude(100.9, roll=-0.2))
    assert (heard.attitude.time, heard.attitude.roll) == pytest.approx((101.0, 0.3))


def test_the_wind_is_where_it_blows_to():
    heard = telemetry()
    for message, wind in (
        # from the West, down: ArduPilot tells the length in space
        (mavlink.MAVLink_wind_message(270.0, math.hypot(8.0, 0.5), 0.5), (8.0, 0.0, -0.5)),
        (mavlink.MAVLink_wind_cov_message(0, 3.0, -4.0, 0.0, 1, 1, 0, 0, 0), (-4.0, 3.0, 0.0)),
        (mavlink.MAVLink_wind_message(math.nan, 8.0, 0.5), (-4.0, 3.0, 0.0)),
    ):
        heard.see(message, 1.0)
        np.testing.assert_allclose(heard.wind, wind, atol=1e-9)


def estimator(level, vertical):
    return mavlink.MAVLink_estimator_status_message(0, 63, *([0.1] * 6), level, vertical)


def receiver(level, vertical, speed):
    """In [mm] and [mm/s]."""
    return mavlink.MAVLink_gps_raw_int_message(
        0, 3, 0, 0, 0, 80, 120, 0, 0, 12, h_acc=level, v_acc=vertical, vel_acc=speed
    )


def told(*messages, now=0.0):
    accuracies = Accuracies()
    for message in messages:
        accuracies.see(message, 0.0)
    return accuracies.noise(now)


def test_the_filter_counts_before_the_receiver():
    noise = told(estimator(0.5, 0.8), receiver(900, 1500, 200))
    assert noise.position == pytest.approx((0.5, 0.5, 0.8))
    assert noise.velocity == pytest.approx((0.2, 0.2, 0.2))
    assert told(receiver(900, 1500, 200)).position == pytest.approx((0.9, 0.9, 1.5))
    assert told(estimator(0.5, 0.8)).velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan, math.inf, 1e12])
def test_what_makes_no_sense_is_unknown(wrong):
    assert told(estimator(wrong, wrong)) is SILENT
    assert told(estimator(wrong, wrong), receiver(900, 1500, 0)).position[0] == pytest.approx(0.9)
    assert told(receiver(0, 0, 0)) is SILENT


def test_what_is_old_and_what_is_no_variance_do_not_count():
    messages = estimator(0.5, 0.8), receiver(900, 1500, 200)
    assert told(*messages, now=AGE) is not SILENT
    assert told(*messages, now=AGE + 0.1) is SILENT
    ratios = mavlink.MAVLink_ekf_status_report_message(831, 0.1, 0.1, 0.1, 0.1, 0.1)
    assert told(ratios) is SILENT


OFFSET = 1234.5  # s, autopilot's time minus ours


def exchange(clock, sent, there, back):
    clock.see_answer(sent, sent + there + OFFSET, sent + there + back)


@pytest.fixture
def clock():
    """After one quick answer."""
    clock = AutopilotClock()
    exchange(clock, 0.0, 0.01, 0.01)
    return clock


def test_until_the_first_answer_the_least_delay_counts():
    clock = AutopilotClock()
    with pytest.raises(ValueError, match="nothing is known"):
        clock.ours(1.0)
    for time, delay in ((1.0, 0.05), (1.02, 0.02), (1.04, 0.2)):
        clock.see_stamp(time + OFFSET, time + delay)
    assert clock.ours(2.0 + OFFSET) == pytest.approx(2.02)


def test_the_quickest_round_trip_counts_and_its_half_bounds_the_error():
    clock, random = AutopilotClock(), np.random.default_rng(1)
    for sent in range(15):
        exchange(clock, float(sent), *random.uniform(0.001, 0.3, 2))
    exchange(clock, 20.0, 0.002, 0.004)
    assert clock.delay == pytest.approx(0.003)
    assert abs(clock.offset - OFFSET) <= clock.delay
    assert clock.ours(30.0 + OFFSET) == pytest.approx(30.0, abs=clock.delay)
    assert 0.01 < clock.jitter < 0.2


def test_an_answer_from_nowhere_changes_nothing(clock):
    before = clock.offset
    # Before it was asked, after too long, not a number, of another boot.
    for answered, arrival in ((OFFSET, 4.0), (OFFSET, 9.0), (math.nan, 5.1), (72.0, 5.01)):
        clock.see_answer(5.0, 5.0 + answered, arrival)
        assert clock.offset == before


def test_a_clock_that_has_fallen_behind_is_believed_again():
    clock, late = AutopilotClock(), 5.0  # s that the autopilot's clock stood still
    for sent in range(5):
        exchange(clock, float(sent), 0.01, 0.01)
    for number in range(50):
        clock.see_stamp(OFFSET - late + 10.0 + 0.02 * number, 10.0 + 0.02 * number)
    for sent in (10.0, 10.5, 11.0):
        clock.see_answer(sent, sent + 0.01 + OFFSET - late, sent + 0.02)
    assert clock.ours(OFFSET - late + 12.0) == pytest.approx(12.0)
    assert clock.restarts == 0


def test_a_clock_that_runs_slower_than_ours_is_followed():
    clock, rate, random = AutopilotClock(), 0.988, np.random.default_rng(1)
    for sent in np.arange(0.0, 60.0, 0.5):
        there, back = random.uniform(0.001, 0.015, 2)
        clock.see_answer(sent, OFFSET + rate * (sent + there), sent + there + back)
        later = sent + 0.5
        assert clock.ours(OFFSET + rate * later) == pytest.approx(later, abs=0.025)


def test_a_restart_is_seen_from_stamps_that_agree(clock):
    clock.see_stamp(OFFSET + 0.9, 0.95)
    for arrival in (1.0, 1.05, 1.11):
        assert clock.restarts == 0
        clock.see_stamp(arrival - 0.9, arrival)
    assert clock.restarts == 1
    assert clock.ours(0.21) == pytest.approx(1.11)


@pytest.mark.parametrize(
    ("stamps", "begin"),
    [
        ((0.5, OFFSET + 1.0, 0.5, OFFSET + 2.0), 0.0),
        ((0.5, 70.0, 0.5, 300.0), 0.0),
        ((OFFSET, OFFSET - 3.0, OFFSET - 2.98, OFFSET - 2.96, OFFSET + 4.0), 0.0),
        (np.arange(OFFSET, OFFSET + 10.0, 0.1), 60.0),  # telemetry may be late
    ],
)
def test_old_repeats_nonsense_and_what_waited_do_not_restart_it(clock, stamps, begin):
    for number, stamp in enumerate(stamps):
        clock.see_stamp(stamp, begin + number * (1.0 if begin == 0.0 else 1e-4))
    assert clock.restarts == 0
