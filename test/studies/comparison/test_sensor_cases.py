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

"""What is asked where a sensor fails: met or missed by numbers, and flown in short."""

import dataclasses

import numpy as np
import pytest

from uav_tracking_mpc.settings.tracking import PREDICTIVE
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop
from uav_tracking_mpc.simulation.flight_log import SensorNews
from uav_tracking_mpc.studies.comparison.measures import Measures
from uav_tracking_mpc.studies.comparison.results import prepared
from uav_tracking_mpc.studies.comparison.scenarios import mismatched, variants
from uav_tracking_mpc.studies.comparison.sensor_cases import ASKED_OF_SENSORS, AskedOfSensors
from uav_tracking_mpc.studies.comparison.sensor_faults import BEGIN, SENSOR_FAULTS

GOOD = Measures(
    range_rms_m=0.1, range_mean_m=0.0, worst_m=0.2, settling_s=10.0, altitude_rms_m=0.1,
    airspeed_rms_mps=0.1, bank_rate_rms_dps=1.0, swing_deg=0.1, softened=1.0,
    envelope_violations=0, violations={}, off_plan=0, altitude_min_m=-0.2, altitude_max_m=0.2,
    airspeed_worst_mps=0.2, airspeed_min_mps=20.0, airspeed_max_mps=24.0,
    airspeed_departed_s=(None,), sensors=((),),
)  # fmt: skip


def told(*news):
    return (tuple(SensorNews(time, "airspeed", state) for time, state in news),)


def missed(asked, **figures):
    return asked.missed(None, {PREDICTIVE: dataclasses.replace(GOOD, **figures)})


@pytest.mark.parametrize(
    ("asked", "bad", "words"),
    [
        ({"worst": 0.3}, {"worst_m": 0.4}, "range error up to 0.4 m"),
        ({"airspeed": 0.5}, {"airspeed_worst_mps": 0.6}, "airspeed up to 0.60 m/s off"),
        ({}, {"airspeed_min_mps": 13.9}, "airspeed from 13.9"),
        ({}, {"airspeed_max_mps": 32.1}, "to 32.1 m/s"),
        ({"overshoot": 0.1}, {"altitude_max_m": 0.2}, "altitude overshoots by 0.20 m"),
        ({"overshoot": 0.1}, {"altitude_min_m": -3.2}, "altitude overshoots by 0.20 m"),
        ({"quiet": True}, {"sensors": told((130.0, "off"))}, "was said to be off after 130.0 s"),
    ],
)
def test_what_is_beyond_its_bound_is_missed(asked, bad, words):
    asked = AskedOfSensors(**{"slowest": 14.0, **asked})
    assert not missed(asked, altitude_max_m=0.0)
    assert [line for line in missed(asked, **bad) if words in line]


@pytest.mark.parametrize(
    ("news", "words"),
    [
        ((), "the airspeed was never named"),
        (((100.0, "off"),), "the airspeed was never named"),
        (((123.0, "off"),), "was named after 123.0 s, must be after 122.0 s"),
        (((121.0, "off"),), "was not used again"),
        (((121.0, "off"), (260.0, "used")), "was not used again"),
        (((121.0, "off"), (215.0, "used")), None),
    ],
)
def test_a_sensor_is_to_be_named_in_time_and_used_again(news, words):
    asked = AskedOfSensors(named="airspeed", within=2.0, recovers=True)
    lines = missed(asked, sensors=told(*news))
    assert not lines if words is None else any(words in line for line in lines)


def test_naming_may_wait_until_the_airspeed_departs():
    asked = AskedOfSensors(named="airspeed", departed=5.0)
    assert not missed(asked)
    assert missed(asked, airspeed_departed_s=(140.0,)) == ["the airspeed was never named"]
    assert not missed(asked, airspeed_departed_s=(140.0,), sensors=told((144.0, "stuck")))
    assert missed(asked, airspeed_departed_s=(140.0,), sensors=told((146.0, "stuck")))


def test_every_fault_is_asked_for_and_said_in_words():
    assert set(ASKED_OF_SENSORS) == set(SENSOR_FAULTS)
    assert all(
        asked.words({}) for name, asked in ASKED_OF_SENSORS.items() if name != "height_steps"
    )


def test_changes_come_in_order_and_differ_by_the_seed():
    for name in SENSOR_FAULTS:
        flights = variants(mismatched("small_uav", name), name)
        for flight in flights:
            times = [time for time, _ in flight.changes]
            assert times == sorted(times)
        if len(flights) > 1 and name != "airspeed_stuck_gusts":
            assert flights[0].changes != flights[1].changes


def flown(name, until, sooner=70.0):
    """A flight of a fault that begins sooner, from a start near the orbit: airspeeds, news."""
    near = (
        "uav_simulator.initial_position=[300.0, 0.0, 120.0]",
        ("uav_simulator.initial_heading=1.5707963267948966"),
    )
    case = prepared(variants(mismatched("small_uav", name, near), name)[0], PREDICTIVE)
    changes = tuple((time - sooner, change) for time, change in case.changes)
    loop = ClosedLoop(dataclasses.replace(case, changes=changes))
    ticks = []
    while loop.time < until:
        ticks.append(loop.tick())
    log = loop.log(until)
    airspeeds = np.array([tick.truth.airspeed for tick in ticks])
    return log, airspeeds, [(news.sensor, news.state) for news in log.sensors]


@pytest.mark.parametrize(
    ("name", "news"),
    [
        ("airspeed_plus_3", [("airspeed", "stuck")]),
        ("airspeed_zero", [("airspeed", "jumped")]),
        ("heading_30", [("heading", "jumped")]),
        ("velocity_flip", [("ground velocity", "off"), ("ground velocity", "used")]),
        ("position_frozen", [("position", "stuck"), ("position", "used")]),
        ("position_silent", [("position", "silent"), ("position", "used")]),
    ],
)
def test_a_failing_sensor_is_named_and_the_orbit_is_held(name, news):
    log, airspeeds, said = flown(name, BEGIN - 70.0 + 35.0)
    assert said == news
    late = log.time > BEGIN - 70.0 + 20.0
    assert np.abs(log.error[late, 0]).max() < 0.3
    assert np.abs(airspeeds[-200:] - 22.0).max() < 1.5


def test_an_airspeed_that_is_stuck_from_the_start_bends_nothing():
    _, airspeeds, said = flown("airspeed_at_26", 60.0)
    assert ("airspeed", "stuck") in said or ("airspeed", "off") in said
    assert airspeeds.min() > 20.0
    assert np.abs(airspeeds[-200:] - 22.0).max() < 0.5


def test_a_wind_that_turns_blames_no_sensor():
    log, _, said = flown("wind_turns", 100.0)
    assert said == []
    assert np.abs(log.error[log.time > 70.0, 0]).max() < 0.3
