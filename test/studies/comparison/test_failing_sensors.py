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

"""Flights in which one thing fails: it is found soon, nothing else is blamed, no limit passed."""

import dataclasses
import math

import numpy as np
import pytest

from uav_tracking_mpc import load_configuration, simulate
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.navigator import Navigator
from uav_tracking_mpc.estimation.sensor_health import USED
from uav_tracking_mpc.simulation.closed_loop import ClosedLoop
from uav_tracking_mpc.studies.comparison.scenarios import mismatched, variants

LONG = pytest.mark.long


BEGIN = 30.0  # s, of what fails on an orbit, near which the flight begins
NEAR = (
    "uav_simulator.initial_position=[300.0, 0.0, 120.0]",
    "uav_simulator.initial_heading=1.5707963267948966",
)


def flown_two_minutes(plant, wrong, *settings):
    """Log of a flight in wind, in which something is wrong from 60 s on."""
    return flown(plant, wrong, *settings, begin=60.0, end=120.0)


def flown_on_orbit(plant, wrong, *settings, end=80.0):
    """The same from near the orbit, from ``BEGIN`` on."""
    return flown(plant, wrong, *NEAR, *settings, begin=BEGIN, end=end)


def flown(plant, wrong, *settings, begin, end):
    if plant == "jsbsim":
        pytest.importorskip("jsbsim")
    overrides = [f"mission.plant={plant}", "uav_simulator.wind=[5.0, 3.0, 0.0]"]
    overrides += [*settings, "nmpc_controller.solve_time_max=10.0"]
    changes = ((begin, f"uav_simulator.{wrong}"),)
    config = dataclasses.replace(load_configuration("small_uav", overrides), changes=changes)
    loop = ClosedLoop(config)
    while loop.time < end:
        loop.tick()
    return loop.log(end)


def misread(monkeypatch, change):
    """Every measurement has other values, by name, that are made from it."""
    step = Controller.step

    def wrong(self, seen, *rest):
        return step(self, dataclasses.replace(seen, **change(seen)), *rest)

    monkeypatch.setattr(Controller, "step", wrong)


@pytest.mark.parametrize(
    ("plant", "angle"),
    [
        ("jsbsim", 1.25),
        pytest.param("vehicle", 1.25, marks=LONG),
        pytest.param("vehicle", 0.25, marks=LONG),
        pytest.param("jsbsim", 0.25, marks=LONG),
    ],
)
def test_a_front_of_the_wind_keeps_the_airspeed(plant, angle):
    """9 m/s in 4 s along the flight: as an airspeed that jumps, until the aircraft is moved by it.

    Whoever believes the ground velocity instead slows down, or speeds up, by as much.
    """
    if plant == "jsbsim":
        pytest.importorskip("jsbsim")
    lasts = 4.0
    told = [*NEAR, f"mission.plant={plant}", "target_publisher.motion=stationary"]
    told += ["uav_simulator.wind=[0.0, 0.0, 0.0]", "nmpc_controller.solve_time_max=10.0"]
    blows = 9.0 * np.array([math.cos(angle * math.pi), math.sin(angle * math.pi), 0.0])
    front = tuple(
        (BEGIN + share * lasts, f"uav_simulator.wind={(share * blows).tolist()}")
        for share in np.linspace(0.05, 1.0, 20)
    )
    loop = ClosedLoop(dataclasses.replace(load_configuration("small_uav", told), changes=front))
    while loop.time < BEGIN + 30.0:
        flown = loop.tick().truth.airspeed
        assert loop.time < BEGIN or flown == pytest.approx(22.0, abs=4.0)
    news = [(each.sensor, each.state) for each in loop.log(loop.time).sensors]
    assert news in ([], [("airspeed", "jumped"), ("airspeed", "used")])  # and soon
    # The airspeed's bias has taken up to 1 m/s of it, which fades slowly.
    assert flown == pytest.approx(22.0, abs=1.5)


@pytest.mark.parametrize(
    ("direction", "told", "bias"),
    [
        ("clockwise", 1.0, 0.1),
        ("counter_clockwise", 0.0, 0.0),
        pytest.param("clockwise", 0.0, 0.0, marks=LONG),
        pytest.param("counter_clockwise", 1.0, 0.1, marks=LONG),
    ],
)
def test_a_heading_that_jumps_is_named_whatever_tells_the_turn(direction, told, bias, monkeypatch):
    """No gyro, or one that is 6 deg/s off: neither is what the heading has changed by itself."""
    estimate = Navigator.estimate

    def of_gyro(self, seen, *rest):
        turn = told * seen.turn_rate + bias
        return estimate(self, dataclasses.replace(seen, turn_rate=turn), *rest)

    monkeypatch.setattr(Navigator, "estimate", of_gyro)
    overrides = [f"nmpc_controller.direction={direction}", "uav_simulator.wind=[5.0, 3.0, 0.0]"]
    jump = ((BEGIN, "uav_simulator.heading_bias=0.3"),)
    config = load_configuration("small_uav", [*NEAR, *overrides])
    loop = ClosedLoop(dataclasses.replace(config, changes=jump))
    while loop.time < BEGIN + 2.0:
        loop.tick()
    news = [(each.sensor, each.state) for each in loop.log(loop.time).sensors]
    assert news == [("heading", "jumped")]


@pytest.mark.parametrize(
    ("plant", "rate", "gusts"),
    [
        ("vehicle", 1.0, 15.4),
        pytest.param("jsbsim", -2.0, 0.0, marks=LONG),
        pytest.param("vehicle", 0.2, 0.0, marks=LONG),
        pytest.param("jsbsim", 1.0, 15.4, marks=LONG),
    ],
)
def test_a_heading_that_drifts_is_left_out(plant, rate, gusts):
    """By so many deg/s: the wind seemed to turn with it, and the orbit was lost by 140 to 500 m."""
    drift = tuple(
        (BEGIN + time, f"uav_simulator.heading_bias={math.radians(rate * time)}")
        for time in np.arange(0.0, 75.0, 0.5)
    )
    overrides = [*NEAR, f"mission.plant={plant}", "uav_simulator.wind=[5.0, 3.0, 0.0]"]
    overrides += [f"uav_simulator.gust_intensity={gusts}", "nmpc_controller.solve_time_max=10.0"]
    config = dataclasses.replace(load_configuration("small_uav", overrides), changes=drift)
    loop = ClosedLoop(config)
    while loop.time < BEGIN + 90.0:
        loop.tick()
    log = loop.log(loop.time)
    assert [(each.sensor, each.state) for each in log.sensors] == [("heading", "off")]
    assert np.abs(log.error[log.time > BEGIN, 0]).max() < 9.0


@pytest.mark.parametrize(
    ("plant", "wrong"),
    [
        pytest.param("vehicle", "velocity_gain=1.5", marks=LONG),
        pytest.param("vehicle", "velocity_bias=[-7.0, -7.0, 0.0]", marks=LONG),
        ("jsbsim", "velocity_gain=0.0"),
        pytest.param("jsbsim", "velocity_bias=[0.0, 0.0, -4.0]", marks=LONG),
    ],
)
def test_a_ground_velocity_that_positions_contradict_is_flown_without(plant, wrong):
    """It is believed at first, and with it a wind that does not blow."""
    log = flown_two_minutes(plant, wrong, "uav_simulator.gust_intensity=7.7")
    named = [each for each in log.sensors if each.sensor == "ground velocity"]
    # For a second it may be taken for air that has changed. One that stays at 0 is stuck.
    assert named[-1].state in ("off", "stuck")
    assert 60.0 <= named[0].time <= named[-1].time < 63.5
    assert {each.sensor for each in log.sensors} <= {"ground velocity", "position"}
    assert np.abs(log.error[log.time > 90.0, 0]).max() < 2.0
    airspeeds = log.vehicle[log.time > 60.0, 5]
    assert 19.0 < airspeeds.min() <= airspeeds.max() < 25.0


@pytest.mark.parametrize(
    ("plant", "wrong", "sensor"),
    [
        ("jsbsim", "heading_bias=0.5", "heading"),
        ("vehicle", "velocity_gain=1.5", "ground velocity"),
        pytest.param("jsbsim", "velocity_gain=0.0", "ground velocity", marks=LONG),
        pytest.param("vehicle", "heading_bias=-0.15", "heading", marks=LONG),
        pytest.param("jsbsim", "velocity_gain=-1.0", "ground velocity", marks=LONG),
        pytest.param("vehicle", "velocity_bias=[-6.0, 4.0, 0.0]", "ground velocity", marks=LONG),
    ],
)
def test_an_aircraft_without_an_airspeed_bears_one_more_failure(plant, wrong, sensor):
    """The gyros tell that a heading jumps, and positions alone how the aircraft moves."""
    log = flown_on_orbit(plant, wrong, "uav_simulator.airspeed_fault=silent")
    named = [each for each in log.sensors if each.sensor == sensor]
    assert {each.state for each in named} <= (
        {"jumped"} if sensor == "heading" else {"off", "stuck"}
    )
    assert BEGIN <= named[0].time < BEGIN + 3.5
    assert np.abs(log.error[log.time > BEGIN + 40.0, 0]).max() < 1.5
    airspeeds = log.vehicle[log.time > BEGIN, 5]
    assert 14.0 <= airspeeds.min() <= airspeeds.max() <= 32.0


@pytest.mark.parametrize(
    ("seed", "airspeed", "wrong"), [(4, 27.0, -6.0), pytest.param(2, 22.0, 6.0, marks=LONG)]
)
def test_an_airspeed_that_nobody_finds_wrong_passes_no_limit(seed, airspeed, wrong):
    """Strong gusts hide it; an orbit that did not keep away reached 34.4 m/s, and 13.3."""
    settings = f"uav_simulator.seed={seed}", "uav_simulator.gust_intensity=15.4"
    orbit = "nmpc_controller.range=300.0", f"nmpc_controller.airspeed={airspeed}"
    log = flown_two_minutes("jsbsim", f"airspeed_bias={wrong}", *settings, *orbit)
    airspeeds = log.vehicle[log.time > 60.0, 5]
    assert not log.sensors
    assert 14.0 <= airspeeds.min() <= airspeeds.max() <= 32.0


@pytest.mark.long
def test_in_gusts_a_rigid_aircraft_flies_as_fast_as_is_asked():
    """What gusts did to the airspeed was taken for a sensor that reads too much."""
    gusts = "uav_simulator.gust_intensity=15.4"
    log = flown("jsbsim", "airspeed_bias=0.0", gusts, *NEAR, begin=0.0, end=300.0)
    assert log.vehicle[log.time > 200.0, 5].mean() == pytest.approx(22.0, abs=0.6)


def test_bank_and_turn_tell_an_airspeed_that_is_wrong_from_the_start():
    """It reads 22 m/s at 14: wind and ground velocity alone took minutes to tell."""
    pytest.importorskip("jsbsim")
    settings = "uav_simulator.airspeed_bias=8.0", "mission.duration=65"
    log = simulate(load_configuration("jsbsim_uav", settings, "crosswind"))
    assert log.error[log.time > 15.0, 4].min() < -5.0
    assert np.abs(log.error[log.time > 60.0, 4]).max() < 1.5
    assert not log.sensors


@pytest.mark.parametrize("plant", ["vehicle", pytest.param("jsbsim", marks=LONG)])
def test_a_height_that_is_stuck_is_carried_on_by_the_velocity(plant):
    """In gusts; what the filter took for a bias of the velocity once led away by 30 m."""
    gusts = "uav_simulator.seed=4", "uav_simulator.gust_intensity=15.4"
    log = flown_two_minutes(plant, "position_fault=level", *gusts)
    assert np.abs(log.vehicle[log.time > 60.0, 2] - 120.0).max() < 6.0
    assert {each.sensor for each in log.sensors} <= {"position"}


@pytest.mark.parametrize("altitude", [280.0, pytest.param(150.0, marks=LONG)])
def test_a_height_that_is_stuck_contradicts_no_climb(altitude):
    """It was the ground velocity that was blamed for it, and the commands ended."""
    settings = ["uav_simulator.initial_position=[591.6,0.0,220.0]", "nmpc_controller.altitude=220"]
    settings += ["nmpc_controller.range=400.0"]
    changes = (
        (BEGIN, "uav_simulator.position_fault=level"),
        (BEGIN + 5.0, f"nmpc_controller.altitude={altitude}"),
    )
    flight = load_configuration("small_uav", [*settings, "mission.duration=85"], "crosswind")
    log = simulate(dataclasses.replace(flight, changes=changes))
    assert np.abs(log.vehicle[log.time > 70.0, 2] - altitude).max() < 5.0
    assert [(each.sensor, each.state) for each in log.sensors] == [("position", "stuck")]


def climbing(share):
    return lambda seen: {"ground_velocity": seen.ground_velocity * [1.0, 1.0, share]}


def reading(share):
    return lambda seen: {"airspeed": share * seen.airspeed}


@pytest.mark.parametrize(
    ("told", "sensor", "state"),
    [
        (climbing(0.0), "ground velocity", "stuck"),  # nothing measures it
        (climbing(-1.0), "ground velocity", "off"),  # counted down
        pytest.param(reading(1.94), "airspeed", "off", marks=LONG),  # knots
        (reading(0.28), "airspeed", "off"),  # m/s taken for km/h
    ],
)
def test_mistakes_in_what_a_source_tells_are_found_from_the_start(told, sensor, state, monkeypatch):
    step = Controller.step

    def mistaken(self, seen, *rest):
        return step(self, dataclasses.replace(seen, **told(seen)), *rest)

    monkeypatch.setattr(Controller, "step", mistaken)
    log = flown_on_orbit("vehicle", "gust_intensity=2.0", end=40.0)
    assert [(each.sensor, each.state) for each in log.sensors] == [(sensor, state)]
    assert np.abs(log.error[log.time > BEGIN, 0]).max() < 1.0
    assert log.vehicle[:, 5].min() > 16.0
    assert log.vehicle[:, 5].max() < 32.0


def turned(angle):
    return lambda seen: {"heading": seen.heading + angle}


@pytest.mark.parametrize(
    ("told", "sensor"),
    [
        (climbing(-1.0), "ground velocity"),
        pytest.param(turned(math.pi), "heading", marks=LONG),
        pytest.param(turned(1.5), "heading", marks=LONG),
        pytest.param(lambda _: {"ground_velocity": [0.0] * 3}, "ground velocity", marks=LONG),
    ],
)
def test_in_gusts_and_with_noisy_positions_a_rigid_aircraft_survives(told, sensor, monkeypatch):
    """Nobody tells the noise of the positions, and at 60 s a sensor fails as badly as it can."""
    step, rng = Controller.step, np.random.default_rng(6)

    def mistaken(self, seen, *rest):
        wrong = told(seen) if seen.stamp > 60.0 else {}
        noisy = seen.position + rng.normal(0.0, 1.5, 3)
        return step(self, dataclasses.replace(seen, position=noisy, **wrong), *rest)

    monkeypatch.setattr(Controller, "step", mistaken)
    log = flown_two_minutes("jsbsim", "velocity_gain=1.0", "uav_simulator.gust_intensity=15.4")
    assert {each.sensor for each in log.sensors if each.state != USED} == {sensor}
    assert all(each.time > 60.0 for each in log.sensors)
    assert np.abs(log.error[log.time > 80.0, 0]).max() < 5.0
    assert np.abs(log.vehicle[log.time > 50.0, 2] - 120.0).max() < 20.0
    assert log.vehicle[:, 5].min() > 14.0


@pytest.mark.parametrize(
    ("velocity", "lost"), [("stuck", 20.0), pytest.param("none", 100.0, marks=LONG)]
)
def test_a_position_that_is_carried_on_comes_to_an_end(velocity, lost):
    """Nobody flies for ever by a place that only wind and velocities tell."""
    faults = {"position_fault": "silent", "velocity_fault": velocity}
    found = BEGIN + lost + 5.0
    changes = [(BEGIN, f"uav_simulator.{name}={fault}") for name, fault in faults.items()]
    changes += [(found, f"uav_simulator.{name}=none") for name in faults]
    config = load_configuration("small_uav", [*NEAR, "uav_simulator.wind=[5.0, 3.0, 0.0]"])
    loop = ClosedLoop(dataclasses.replace(config, changes=tuple(changes)))
    while loop.time < found + 5.0:
        loop.tick()
    silent, again = loop.log(loop.time).modes[-2:]
    assert silent.mode is FallbackMode.SILENCE
    assert silent.time == pytest.approx(BEGIN + lost, abs=1.5)
    assert again.mode.nominal
    assert found <= again.time < found + 4.0


@pytest.mark.parametrize(
    ("plant", "told"),
    [
        ("jsbsim", lambda place, rng: place + np.array([0.0, 0.0, 300.0])),
        pytest.param("vehicle", lambda place, rng: place + np.array([0.0, 0.0, 300.0]), marks=LONG),
        ("vehicle", lambda place, rng: rng.normal(0.0, 0.3, 3)),
        pytest.param("jsbsim", lambda place, rng: rng.normal(0.0, 0.3, 3), marks=LONG),
        pytest.param("jsbsim", lambda place, rng: np.full(3, 1e9), marks=LONG),
    ],
)
def test_a_place_that_all_other_sensors_contradict_is_not_flown_by(plant, told, monkeypatch):
    """For 20 s a wrong height, or the place of a receiver without a fix."""
    step, rng = Controller.step, np.random.default_rng(1)

    def wrong(self, seen, *rest):
        if BEGIN <= seen.stamp < BEGIN + 20.0:
            seen = dataclasses.replace(seen, position=told(seen.position, rng))
        return step(self, seen, *rest)

    monkeypatch.setattr(Controller, "step", wrong)
    log = flown_on_orbit(plant, "position_bias=[0.0,0.0,0.0]", end=60.0)
    assert {each.sensor for each in log.sensors} == {"position"}
    assert log.sensors[-1].state == USED
    since = log.time >= BEGIN
    assert np.abs(log.vehicle[since, 2] - 120.0).max() < 2.0
    assert np.abs(log.error[since, 0]).max() < 3.0


@pytest.mark.parametrize("every", [0.5, 1.0])
def test_a_height_may_come_more_often_than_the_place_beside_it(every, monkeypatch):
    """As of a barometer beside a slow receiver: its place would be taken for one that is stuck."""
    told = {}

    def change(seen):
        if seen.stamp >= told.get("next", 0.0):
            told["next"] = seen.stamp + every
            told["fix"] = seen.position[:2], seen.ground_velocity
        (east, north), velocity = told["fix"]
        return {"position": np.array([east, north, seen.position[2]]), "ground_velocity": velocity}

    misread(monkeypatch, change)
    log = flown_on_orbit("jsbsim", "position_bias=[0.0,0.0,0.0]")
    assert not log.sensors
    assert np.abs(log.error[log.time > 40.0, 0]).max() < 2.0


@pytest.mark.parametrize("rise", [lambda z: 3.28 * z, lambda z: z + 60.0], ids=["feet", "offset"])
def test_a_height_that_is_far_too_great_is_never_followed_to_the_ground(rise, monkeypatch):
    def change(seen):
        east, north, up = seen.position.tolist()
        return {"position": np.array([east, north, rise(up) if seen.stamp >= BEGIN else up])}

    misread(monkeypatch, change)
    log = flown_on_orbit("vehicle", "position_bias=[0.0,0.0,0.0]", end=100.0)
    assert [(each.sensor, each.state) for each in log.sensors] == [("position", "jumped")]
    assert np.abs(log.vehicle[log.time >= BEGIN, 2] - 120.0).max() < 2.0


@pytest.mark.parametrize(
    ("plant", "climb"),
    [
        ("jsbsim", -1.0),
        ("jsbsim", 1.0),
        pytest.param("vehicle", -1.0, marks=LONG),
        pytest.param("vehicle", 1.0, marks=LONG),
    ],
)
def test_a_height_that_counts_down_is_found_and_turned_over(plant, climb, monkeypatch):
    """Alone or with the climb: the aircraft would climb away from its target."""

    def change(seen):
        east, north, up = seen.ground_velocity.tolist()
        velocity = np.array([east, north, climb * up])
        return {"position": seen.position * [1.0, 1.0, -1.0], "ground_velocity": velocity}

    misread(monkeypatch, change)
    log = flown_on_orbit(plant, "position_bias=[0.0,0.0,0.0]", end=50.0)
    settled = log.time > 40.0
    assert log.vehicle[:, 2].max() < 170.0
    assert np.abs(log.vehicle[settled, 2] - 120.0).max() < 1.0
    assert np.abs(log.error[settled, 0]).max() < 1.0


def test_a_heading_that_counts_from_north_to_east_is_found_and_turned_over(monkeypatch):
    """From the start: without that the aircraft flies kilometres away."""
    misread(monkeypatch, lambda seen: {"heading": 0.5 * math.pi - seen.heading})
    log = flown_on_orbit("jsbsim", "position_bias=[0.0,0.0,0.0]", end=70.0)
    assert not log.sensors
    assert np.abs(log.error[log.time > 55.0, 0]).max() < 1.0


def test_an_aircraft_whose_bank_is_of_another_sign_does_not_swing(monkeypatch):
    """By its nose it would: that turns outwards as it rolls, and so the wrong way."""
    misread(monkeypatch, lambda seen: {"bank": -seen.bank if seen.stamp >= BEGIN else seen.bank})
    log = flown_on_orbit("jsbsim", "position_bias=[0.0,0.0,0.0]")
    settled = log.time > BEGIN + 15.0
    bank_rate = np.diff(log.bank[settled]) / np.diff(log.time[settled])
    assert np.degrees(np.sqrt(np.mean(bank_rate**2))) < 1.3
    assert np.abs(log.error[settled, 0]).max() < 1.0


def test_a_compass_that_drifts_before_the_wind_is_known_is_found_in_gusts(monkeypatch):
    """By 1 deg/s from 8 s on: a gust of 12 m/s would be believed, and the way lost."""

    def change(seen):
        return {"heading": seen.heading + max(0.0, seen.stamp - 8.0) * math.radians(1.0)}

    misread(monkeypatch, change)
    gusts = "uav_simulator.gust_intensity=1.0"
    log = flown_on_orbit("jsbsim", "position_bias=[0.0,0.0,0.0]", gusts, end=100.0)
    assert [(each.sensor, each.state) for each in log.sensors] == [("heading", "off")]
    assert np.abs(log.error[log.time > 40.0, 0]).max() < 2.0


def test_a_compass_that_drifts_while_there_is_no_airspeed_gives_way_to_the_gyros(monkeypatch):
    """By 1 deg/s, in a flight that nobody else can judge: the aircraft would hit the ground."""

    def change(seen):
        heading = seen.heading + max(0.0, seen.stamp - 150.0) * math.radians(1.0)
        return {"heading": heading, "airspeed": seen.airspeed if seen.stamp < 130.0 else None}

    misread(monkeypatch, change)
    log = flown_on_orbit("jsbsim", "position_bias=[0.0,0.0,0.0]", end=300.0)
    assert [each.sensor for each in log.sensors] == ["airspeed", "heading"]
    assert log.vehicle[:, 2].min() > 70.0
    assert np.abs(log.error[log.time > BEGIN, 0]).max() < 6.0
    assert np.abs(log.error[log.time > 280.0, 0]).max() < 1.0


def test_what_stands_in_for_a_velocity_blames_no_compass(monkeypatch):
    """One with 9 deg of soft iron, after the ground velocity has become stuck."""
    stuck = []

    def change(seen):
        heading = seen.heading + math.radians(9.0) * math.sin(2.0 * seen.heading)
        if seen.stamp >= BEGIN:
            stuck.append(seen.ground_velocity)
        velocity = stuck[0] if stuck else seen.ground_velocity
        return {"heading": heading, "ground_velocity": velocity}

    misread(monkeypatch, change)
    log = flown_on_orbit("vehicle", "position_bias=[0.0,0.0,0.0]", end=100.0)
    assert [(each.sensor, each.state) for each in log.sensors] == [("ground velocity", "stuck")]
    assert np.abs(log.error[log.time > 40.0, 0]).max() < 2.0


@LONG
def test_gusts_on_a_straight_way_in_blame_no_sensor():
    """All that is known of the wind then comes from one direction."""
    for case in variants(mismatched("small_uav", "gust_light"), "gust_light"):
        loop = ClosedLoop(case)
        while loop.time < 40.0:
            loop.tick()
        log = loop.log(40.0)
        assert not log.sensors
        assert abs(log.error[-1, 0]) < 3.0


@pytest.mark.parametrize("absent", [False, pytest.param(True, marks=LONG)])
def test_a_receiver_that_comes_less_often_than_the_attitude_is_flown_by(absent, monkeypatch):
    """4 Hz beside 20: it repeats what it measured last, or tells no position in between."""
    step, rng, fix = Controller.step, np.random.default_rng(3), {}

    def seldom(self, seen, *rest):
        fresh = round(20.0 * seen.stamp) % 5 == 0
        if fresh:
            place = seen.position + rng.normal(0.0, 0.5, 3)
            fix.update(position=place, ground_velocity=seen.ground_velocity)
        told = {**fix, "position": fix["position"] if fresh or not absent else np.full(3, math.nan)}
        return step(self, dataclasses.replace(seen, **told), *rest)

    monkeypatch.setattr(Controller, "step", seldom)
    log = flown_on_orbit("jsbsim", "position_bias=[8.0,0.0,0.0]", "uav_simulator.seed=2", end=60.0)
    news = [(each.sensor, each.state) for each in log.sensors]
    assert news == [("position", "jumped"), ("position", USED)]
    assert log.softened == 1.0  # nothing swings
    before = (log.time > 15.0) & (log.time < BEGIN)
    assert np.abs(log.error[before, 0]).max() < 1.0
    assert np.abs(log.vehicle[before, 5] - 22.0).max() < 0.7


def test_positions_that_become_noisy_are_left_out_until_their_noise_is_known(monkeypatch):
    """Each of them is far from where it should be, and none is where the aircraft is."""
    step, rng, place = Controller.step, np.random.default_rng(1), [np.zeros(3)]

    def noisy(self, seen, *rest):
        if round(20.0 * seen.stamp) % 4 == 0:
            place[0] = seen.position + rng.normal(0.0, 0.15 if seen.stamp < BEGIN else 5.0, 3)
        return step(self, dataclasses.replace(seen, position=place[0]), *rest)

    monkeypatch.setattr(Controller, "step", noisy)
    log = flown_on_orbit("vehicle", "position_bias=[0.0,0.0,0.0]", end=60.0)
    assert {each.sensor for each in log.sensors} == {"position"}
    assert np.abs(log.error[log.time > BEGIN, 0]).max() < 2.5


@LONG
def test_a_receiver_that_comes_once_a_second_is_flown_by_in_gusts(monkeypatch):
    """Its noisy positions and velocities repeat themselves in between, at 20 Hz."""
    step, rng, fix = Controller.step, np.random.default_rng(3), {}

    def seldom(self, seen, *rest):
        if round(20.0 * seen.stamp) % 20 == 0:
            place = seen.position + rng.normal(0.0, 0.5, 3)
            fix.update(position=place, ground_velocity=seen.ground_velocity)
        return step(self, dataclasses.replace(seen, **fix), *rest)

    monkeypatch.setattr(Controller, "step", seldom)
    gusts = "uav_simulator.gust_intensity=7.7", "uav_simulator.seed=4"
    log = flown("jsbsim", "velocity_gain=1.0", *NEAR, *gusts, begin=0.0, end=70.0)
    late = log.time > 20.0
    assert np.sqrt(np.mean(log.error[late, 0] ** 2)) < 0.44
    assert np.sqrt(np.mean((log.vehicle[late, 2] - 120.0) ** 2)) < 0.9
    assert {each.sensor for each in log.sensors} <= {"position"}
