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

"""Numbers of a flight against closed forms, and against the published simulation."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from example_flights import ORBIT, log_of, orbiting

from uav_tracking_mpc.dynamics.air import GRAVITY
from uav_tracking_mpc.dynamics.orbit import COUNTER_CLOCKWISE, Orbit
from uav_tracking_mpc.dynamics.vehicle import velocity
from uav_tracking_mpc.report.metrics import (
    bank_rate_rms,
    metrics,
    range_errors,
    settling_time,
    verdict,
)
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.simulation.flight_log import CommandCounts, Latency, LinkFigures, SensorNews

KEYS = {
    "config": None,
    "duration_s": None,
    "speed": None,
    "settling_s": {"range", "altitude", "speed", "bearing"},
    "settling_bands": {"range", "altitude", "speed", "bearing"},
    "steady_state": {
        "range_rms_m",
        "range_max_m",
        "altitude_rms_m",
        "speed_rms_mps",
        "horizontal_rms_m",
        "bank_rate_rms_dps",
    },
    "final": {
        "range_error_m",
        "bearing_error_rad",
        "altitude_error_m",
        "pitch_error_rad",
        "speed_error_mps",
    },
    "solver": {"name", "median_us", "p99_us", "max_us", "solves", "failures"},
    "commands": {"sent", "late", "plan_reused", "failsafe"},
    "sensors": {"airspeed", "heading", "position", "ground velocity"},
}


def states(count: int) -> np.ndarray:
    """Relative states of a perfect orbit, for tests to disturb, shape (count, 5)."""
    return np.tile(ORBIT.steady_state, (count, 1))


def assert_plain(value: object) -> None:
    """Only what JSON can hold: no NumPy types, no NaN."""
    if isinstance(value, dict):
        for inner in value.values():
            assert_plain(inner)
    elif isinstance(value, list):
        for inner in value:
            assert_plain(inner)
    else:
        assert value is None or type(value) in (str, int, float)


def test_the_keys_are_the_contract():
    """metrics.json is read by other programs: its keys are fixed."""
    numbers = metrics(orbiting())
    assert numbers.keys() == KEYS.keys()
    for key, inner in KEYS.items():
        assert inner is None or numbers[key].keys() == inner


def test_a_sensor_that_failed_has_its_faults():
    news = [
        SensorNews(0.2, "airspeed", "jumped"),
        SensorNews(0.5, "airspeed", "used"),
        SensorNews(0.6, "heading", "off"),
    ]
    log = orbiting(21, step=0.05, sensors=tuple(news))
    sensors = metrics(log)["sensors"]
    (fault,) = sensors["airspeed"]["faults"]
    assert (fault["state"], fault["begin_s"]) == ("jumped", 0.2)
    assert fault["duration_s"] == pytest.approx(0.3)
    assert sensors["airspeed"]["used"] == pytest.approx(0.7)
    assert sensors["heading"]["refused"] == pytest.approx(0.4)
    assert sensors["position"] == {"used": 1.0, "refused": 0.0, "faults": []}
    assert "The airspeed was left out for 30.0% of the flight" in verdict(metrics(log))
    news[1] = SensorNews(0.2005, "airspeed", "used")
    numbers = metrics(orbiting(21, step=0.05, sensors=tuple(news)))
    assert "The airspeed was left out for less than 0.1% of the flight" in verdict(numbers)


def test_latency_only_where_it_was_measured():
    """A simulation has no messages, hence no latency."""
    assert "latency_us" not in metrics(orbiting())
    flown = metrics(orbiting(latency=Latency(median=700.0, p99=900.0, max=float("nan"))))
    assert flown["latency_us"] == {"median": 700.0, "p99": 900.0, "max": None}


def test_a_link_only_where_there_was_one():
    assert "link" not in metrics(orbiting())
    link = LinkFigures("ardupilot", 50.0, 2.5, float("nan"), 3, 1)
    assert metrics(orbiting(link=link))["link"] == {
        "dialect": "ardupilot",
        "rate_hz": 50.0,
        "latency_ms": 2.5,
        "latency_p99_ms": None,
        "lost": 3,
        "refused": 1,
    }


@pytest.mark.parametrize("step", [0.01, 0.02, 0.05])
def test_bank_rate_of_a_bank_that_swings(step):
    """tan(bank) = v psi' / g is small for psi' = 0.01 sin(w t): RMS v 0.01 w / (g sqrt 2)."""
    log, w = orbiting(round(60.0 / step) + 1, step=step), 2.0 * np.pi / 5.0
    log.vehicle[:, 3] = -0.01 / w * np.cos(w * log.time)
    expected = np.degrees(ORBIT.speed * 0.01 * w / GRAVITY / np.sqrt(2.0))
    assert bank_rate_rms(log) == pytest.approx(expected, rel=5e-3)


def test_bank_rate_is_that_of_the_measured_bank_where_there_is_one():
    log, w = orbiting(3001, step=0.02), 2.0 * np.pi / 5.0
    heading = log.vehicle[:, 3]
    heading += 0.01 * np.random.default_rng(1).normal(size=len(heading))
    log = replace(log, measured_bank=0.1 * np.sin(w * log.time))
    assert bank_rate_rms(log) == pytest.approx(np.degrees(0.1 * w / np.sqrt(2.0)), rel=5e-3)


def test_a_stamp_that_steps_back_is_left_out_of_the_bank_rate():
    log, w = orbiting(3001, step=0.02), 2.0 * np.pi / 5.0
    log = replace(log, measured_bank=0.1 * np.sin(w * log.time))
    log.time[2500] -= 0.03
    assert bank_rate_rms(log) == pytest.approx(np.degrees(0.1 * w / np.sqrt(2.0)), rel=5e-3)


def test_without_samples_there_is_no_bank_rate():
    assert bank_rate_rms(orbiting(10)) is None


@pytest.mark.parametrize("orbit", [ORBIT, Orbit(300.0, 120.0, 22.0, COUNTER_CLOCKWISE)])
def test_a_perfect_orbit_has_no_error(orbit):
    """In either direction, whatever the heading does meanwhile."""
    numbers = metrics(orbiting(400, orbit))
    assert numbers["settling_s"] == {"range": 0.0, "altitude": 0.0, "speed": 0.0, "bearing": 0.0}
    for value in [*numbers["steady_state"].values(), *numbers["final"].values()]:
        assert value == pytest.approx(0.0, abs=1e-9)


def test_constant_offsets_are_their_own_rms():
    """2 m of range at the right altitude, 0.05 m/s of speed."""
    relative = states(90) + np.array([2.0, 0.0, 0.0, 0.0, -0.05])
    log = log_of(relative)
    numbers = metrics(log)
    steady = numbers["steady_state"]
    assert steady["range_rms_m"] == pytest.approx(2.0)
    assert steady["range_max_m"] == pytest.approx(2.0)
    assert steady["altitude_rms_m"] == pytest.approx(0.0, abs=1e-9)
    assert steady["speed_rms_mps"] == pytest.approx(0.05)
    assert steady["horizontal_rms_m"] == pytest.approx(np.sqrt(152.0**2 - 50.0**2) - ORBIT.radius)
    assert range_errors(log).mean() == pytest.approx(2.0)
    assert numbers["settling_s"]["range"] is None
    assert numbers["settling_s"]["speed"] == 0.0


def test_only_the_last_third_is_steady_state():
    """Errors before it do not count; an oscillation of amplitude a there has RMS a / sqrt(2)."""
    relative = states(301)
    relative[:200, 0] += 100.0
    relative[200:, 2] += 3.0 * np.sin(2.0 * np.pi * np.arange(101) / 20.0)
    steady = metrics(log_of(relative))["steady_state"]
    assert steady["range_max_m"] == pytest.approx(0.0, abs=1e-9)
    assert steady["altitude_rms_m"] == pytest.approx(3.0 / np.sqrt(2.0), rel=0.01)


def test_gusts_widen_the_bands_by_three_of_their_standard_deviations():
    log = orbiting(300)
    gusts = np.where(np.arange(300) % 2, 0.5, -0.5)[:, None] * np.ones(3)
    steady = np.array([8.0, 0.0, 0.0])
    through_air = np.array([velocity(state) for state in log.vehicle])
    still = metrics(replace(log, ground_velocity=through_air + steady))["settling_bands"]
    assert still == pytest.approx({"range": 1.0, "altitude": 1.0, "speed": 0.1, "bearing": 0.05})
    moved = metrics(replace(log, ground_velocity=through_air + steady + gusts))["settling_bands"]
    bearing = 0.05 + 1.5 / ORBIT.speed
    assert moved == pytest.approx({"range": 2.5, "altitude": 2.5, "speed": 1.6, "bearing": bearing})


def test_a_flight_in_gusts_settles():
    configuration = load_configuration("small_uav", ["mission.duration=40.0"], "gusts")
    times = metrics(simulate(configuration))["settling_s"]
    assert all(time is not None for time in times.values())
    assert 10.0 < times["range"] < 25.0


def test_settling_counts_from_the_last_exit():
    """Inside at 10 s, out again at 20 s, inside for good from 31 s on."""
    relative = states(60)
    relative[:10, 0] += 5.0
    relative[20:31, 0] -= 1.5
    assert metrics(log_of(relative))["settling_s"]["range"] == 31.0
    assert metrics(log_of(relative, step=0.5))["settling_s"]["range"] == 15.5


def test_settling_needs_a_last_sample_inside():
    """A flight that leaves at its end has not settled; the band's edge is outside."""
    time = np.arange(4.0)
    assert settling_time(time, np.array([0.0, 0.0, 0.0, 1.1]), 1.0) is None
    assert settling_time(time, np.array([0.0, 0.0, 0.0, 1.0]), 1.0) is None
    assert settling_time(time, np.array([0.0, np.nan, 0.0, 0.9]), 1.0) == 2.0
    assert settling_time(np.zeros(0), np.zeros(0), 1.0) is None


def test_bearing_error_is_an_angle():
    """A bearing just past -pi is 0.02 rad, not 2 pi, from one just before pi."""
    orbit = Orbit(150.0, 50.0, 4.0, COUNTER_CLOCKWISE)  # theta_ss = -pi/2
    past = np.array([0.0, 2.0 * np.pi + 0.01, 0.0, 0.0, 0.0])
    relative = np.tile(orbit.steady_state + past, (9, 1))
    numbers = metrics(log_of(relative, orbit))
    assert numbers["final"]["bearing_error_rad"] == pytest.approx(0.01)
    assert numbers["settling_s"]["bearing"] == 0.0


def test_final_errors_are_signed():
    """Flown minus desired."""
    relative = states(3)
    relative[-1] += [-4.0, 0.1, -3.0, 0.2, 0.5]
    final = metrics(log_of(relative))["final"]
    assert list(final.values()) == pytest.approx([-4.0, 0.1, -3.0, 0.2, 0.5])


def test_solver_and_commands():
    """Wall times in microseconds; counts pass through."""
    numbers = metrics(
        orbiting(
            solve_time=np.array([1e-3, 2e-3, 3e-3, np.nan]),
            failures=1,
            commands=CommandCounts(sent=4, late=3, plan_reused=2, failsafe=1),
        )
    )
    solver = numbers["solver"]
    assert solver["median_us"] == pytest.approx(2000.0)
    assert solver["p99_us"] == pytest.approx(2980.0)
    assert solver["max_us"] == pytest.approx(3000.0)
    assert (solver["solves"], solver["failures"]) == (4, 1)
    assert numbers["commands"] == {"sent": 4, "late": 3, "plan_reused": 2, "failsafe": 1}


@pytest.mark.parametrize("count", [0, 1, 2])
def test_short_records(count):
    """No sample, one, two; no command."""
    log = orbiting(count)
    numbers = metrics(log)
    assert_plain(numbers)
    assert (numbers["final"]["range_error_m"] is None) == (count == 0)
    assert (len(range_errors(log)) == 0) == (count == 0)
    json.dumps(numbers, allow_nan=False)


def test_values_that_are_not_finite_become_null():
    """A record with holes still makes valid JSON."""
    log = orbiting(30)
    vehicle = log.vehicle.copy()
    vehicle[-1, 0] = np.nan
    log = replace(log, vehicle=vehicle, speed=float("inf"), solve_time=np.full(29, np.nan))
    numbers = metrics(log)
    assert_plain(numbers)
    assert numbers["final"]["range_error_m"] is None
    assert numbers["settling_s"]["range"] is None
    assert numbers["speed"] is None
    json.dumps(numbers, allow_nan=False)
