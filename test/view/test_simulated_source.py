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

"""A simulation is seen as it is flown, and does what is asked of it between two ticks."""

import math
import sys
import threading
from types import SimpleNamespace

import numpy as np
import pytest
from stepped_simulation import LONG_ENOUGH, SteppedSimulation

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.parameters.specification import ParameterError
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.view import simulated_source
from uav_tracking_mpc.view.simulated_source import MOST_BEHIND, SimulatedSource
from uav_tracking_mpc.view.simulated_steering import (
    CONTROLLER_KILLED,
    DURATIONS,
    STATE_LOST,
    TARGET_LOST,
)
from uav_tracking_mpc.view.watched_flight import CONTROLLER, SIMULATOR, TARGET

LAW = "nmpc_controller.law=l1"  # quick to fly


@pytest.fixture(scope="module")
def flown():
    simulation = SteppedSimulation(scenario="wind")
    return simulation, simulation.fly(30.0)


def test_it_is_the_flight_of_simulate(flown):
    """Bit for bit, of which the first 10 s tell: watching changes nothing."""
    simulation, _ = flown
    overrides = [LONG_ENOUGH, "mission.duration=10"]
    plain = simulate(load_configuration("small_uav", overrides, "wind"))
    watched, ticks = simulation.loop.log(30.0), len(plain.inputs)
    np.testing.assert_array_equal(watched.time[: ticks + 1], plain.time)
    np.testing.assert_array_equal(watched.vehicle[: ticks + 1], plain.vehicle)
    np.testing.assert_array_equal(watched.inputs[:ticks], plain.inputs)
    assert watched.orbits == ()


def test_there_is_everything_to_see(flown):
    _, sights = flown
    sight = sights[-1]
    assert sight.mode is FallbackMode.OPTIMAL
    np.testing.assert_allclose(sight.wind, [8.0, 0.0, 0.0], atol=0.2)
    np.testing.assert_allclose(sight.target.position, np.zeros(3), atol=0.1)
    assert 0.0 < sight.target.std < 1.0
    np.testing.assert_array_equal(sight.target.measured, np.zeros(3))
    np.testing.assert_array_equal(sight.target.truth, np.zeros(3))
    radius = math.sqrt(300.0**2 - 120.0**2)
    assert abs(sight.wanted.radius) == pytest.approx(radius)
    assert sight.flown.radius == pytest.approx(sight.wanted.radius, rel=0.01)
    assert sight.cost >= 0.0
    assert sight.solve_time > 0.0
    assert [status.level for status in sight.statuses] == [0, 0, 0]


def test_errors_and_bank_are_those_of_the_log(flown):
    simulation, sights = flown
    log = simulation.loop.log(30.0)
    errors = [list(sight.errors.values()) for sight in sights[1:]]
    np.testing.assert_allclose(errors, log.error[1:-1], atol=1e-9)
    turn = np.gradient(np.unwrap(log.vehicle[:, 3]), log.time)
    level = turn * log.vehicle[:, 5] / 9.80665
    banks = np.array([sight.bank for sight in sights])
    np.testing.assert_allclose(np.tan(banks)[200:], -level[200:-1], atol=0.01)


def test_the_plan_leads_from_the_aircraft_to_where_it_goes(flown):
    _, sights = flown
    times = np.array([sight.time for sight in sights])
    places = np.array([sight.position for sight in sights])
    sight = sights[400]
    np.testing.assert_array_equal(sight.plan[0], sight.position)
    later = [np.interp(sight.time + 2.0, times, axis) for axis in places.T]
    assert np.linalg.norm(sight.plan[5] - later) < 2.0  # five stages of 0.4 s: 44 m


def test_before_the_target_is_seen_there_is_the_aircraft_alone():
    simulation = SteppedSimulation(LAW, "target_publisher.delay=1.0")
    assert simulation.flight.sight is None
    sight = simulation.fly(0.5)[-1]
    assert (sight.target, sight.wanted, sight.plan, sight.mode) == (None, None, None, None)
    assert not sight.errors
    assert simulation.fly(1.0)[-1].mode is FallbackMode.GUIDANCE_LAW


def test_what_is_past_is_kept_for_a_time_and_no_longer(monkeypatch):
    monkeypatch.setattr(simulated_source, "PAST_SPAN", 4.0)
    simulation = SteppedSimulation(LAW)
    simulation.fly(8.0)
    past = simulation.flight.past(1e9)
    assert len(past) == 20
    assert past[-1].time - past[0].time == pytest.approx(3.8)
    assert simulation.flight.past(1.0) == past[-6:]
    assert past[0].plan is None


@pytest.mark.parametrize("speed", [0.5, 8.0])
def test_it_keeps_its_pace_without_drift(speed):
    """However irregular the thread runs, as long as it is not far behind."""
    simulation = SteppedSimulation(LAW, f"mission.speed={speed}")
    period, rng = 1.0 / simulation.loop.rate, np.random.default_rng(1)
    while simulation.wall < 2.0:
        simulation.wall += rng.uniform(0.0, 0.8 * MOST_BEHIND)
        while simulation.flight.advance() == 0.0:
            pass
        assert 0.0 <= simulation.loop.time - speed * simulation.wall <= period + 1e-9


def test_time_that_was_lost_is_not_caught_up_with():
    simulation = SteppedSimulation(LAW)
    simulation.wait(1.0)
    time = simulation.loop.time
    simulation.wall += 100.0
    simulation.wait(1.0)
    assert simulation.loop.time == pytest.approx(time + 1.0, abs=0.2)


def test_a_plant_that_fails_stands_until_it_is_reset():
    simulation = SteppedSimulation(LAW)
    simulation.fly(2.0)
    simulation.loop.plant.state[2] = np.nan
    simulation.wait(1.0)
    time = simulation.loop.time
    failed = {status.node: status for status in simulation.flight.sight.statuses}[SIMULATOR]
    assert failed.level == 2
    assert "the plant failed: at 2 s the plant's position is" in failed.words
    simulation.wait(1.0)
    assert simulation.loop.time == time
    assert simulation.ask(simulation.steering.reset) == ""
    assert simulation.fly(5.0)[-1].mode is FallbackMode.GUIDANCE_LAW


def test_a_plant_that_fails_before_there_is_something_to_see_says_so():
    simulation = SteppedSimulation(LAW)
    simulation.loop.plant.state[2] = np.nan
    simulation.wait(1.0)
    words = SimulatedSource.words.fget(SimpleNamespace(_flight=simulation.flight))
    assert "the plant failed: at 0 s the plant's position is" in words


def test_the_thread_flies_answers_and_ends():
    configuration = load_configuration("small_uav", [LAW, "mission.speed=100.0"])
    seen = threading.Event()

    def witness(now, measured, command):
        if now > 5.0 and command is not None:
            seen.set()

    source = SimulatedSource(configuration, witness)
    (flight,) = source.flights()
    assert seen.wait(60.0)
    assert flight.steering.send_target(50.0, 0.0) == ""
    assert flight.steering.pause(True) == ""
    time = flight.sight.time
    assert flight.steering.inject("rain") != ""
    assert flight.sight.time == time
    source.close()
    assert flight.steering.pause(False) == "the simulation has ended"
    log = source.log()
    assert log.duration == pytest.approx(time)
    assert log.speed == 100.0


def test_the_log_of_an_hour_is_small():
    """18 numbers a state and 7 a command, 20 of each a second."""
    simulation = SteppedSimulation(LAW)
    simulation.fly(5.0)
    recorder = simulation.loop._recorder
    arrays = [value for value in vars(recorder).values() if hasattr(value, "buffer_info")]
    held = sum(len(column) * column.itemsize for column in arrays)
    assert held / 5.0 * 3600.0 < 15e6
    assert sum(map(sys.getsizeof, arrays)) < 2 * held


@pytest.fixture(scope="module")
def settled():
    """A flight on its orbit; each test goes on from where the one before has left it."""
    simulation = SteppedSimulation()
    simulation.fly(40.0)
    return simulation


def circles(sights):
    """Whether each of the sights is within 1 m of the range and altitude that are asked for."""
    return all(
        abs(sight.errors["range_error"]) < 1.0 and abs(sight.errors["altitude_error"]) < 1.0
        for sight in sights
    )


def test_an_orbit_that_cannot_be_flown_is_refused_in_the_controllers_words(settled):
    before = settled.loop.controller.parameters
    answer = settled.ask(settled.steering.change, CONTROLLER, range=20.0)
    with pytest.raises(ParameterError) as refusal:
        settled.loop.controller.change(range=20.0)
    assert answer == str(refusal.value)
    assert "range is 20.0 m" in answer
    assert settled.loop.controller.parameters is before
    assert settled.steering.parameters(CONTROLLER)["range"] == 300.0


def test_the_aircraft_circles_the_place_to_which_the_target_is_sent_within_a_minute(settled):
    begin = settled.loop.time
    assert settled.ask(settled.steering.send_target, 60.0, -80.0) == ""
    assert settled.steering.parameters(TARGET)["position"] == (60.0, -80.0, 0.0)
    settled.fly(60.0)
    sights = settled.fly(5.0)
    assert sights[0].time <= begin + 60.0 + 1e-6
    assert circles(sights)
    np.testing.assert_allclose(sights[0].target.position, [60.0, -80.0, 0.0], atol=0.1)
    distance = math.dist(sights[0].position, (60.0, -80.0, 0.0))
    assert distance == pytest.approx(300.0, abs=1.0)


@pytest.mark.parametrize(
    ("east", "words"), [(1e9, "must be a list of 3 numbers"), (math.nan, "must be a list")]
)
def test_a_place_that_is_none_is_refused(settled, east, words):
    before = settled.loop.target.parameters
    assert words in settled.ask(settled.steering.send_target, east, 0.0)
    assert settled.loop.target.parameters is before


def test_what_is_fixed_or_unknown_is_refused_by_its_owner(settled):
    ask, change = settled.ask, settled.steering.change
    assert "must stay 0 while the simulator runs" in ask(change, SIMULATOR, seed=3)
    assert "did you mean 'line'?" in ask(change, TARGET, motion="lin")
    assert "'horizon' is 5, must stay 22" in ask(change, CONTROLLER, horizon=5)
    assert "fault is 'rain', must be one of" in ask(settled.steering.inject, "rain")


def test_another_orbit_is_flown_and_recorded(settled):
    assert settled.ask(settled.steering.change, CONTROLLER, range=250.0, altitude=100.0) == ""
    settled.fly(20.0)
    assert circles(settled.fly(2.0))
    log = settled.loop.log(settled.loop.time)
    assert [orbit.range for _, orbit in log.orbits] == [300.0, 250.0]
    assert abs(log.error[-1, 0]) < 1.0


def test_the_air_and_the_motion_of_the_target_change_in_flight(settled):
    ask, change = settled.ask, settled.steering.change
    assert ask(change, SIMULATOR, wind=[4.0, 0.0, 0.0]) == ""
    assert ask(change, TARGET, motion="line", speed=3.0, heading=0.0) == ""
    settled.fly(20.0)
    (sight,) = settled.fly(0.05)
    np.testing.assert_allclose(settled.loop.plant.wind, [4.0, 0.0, 0.0])
    np.testing.assert_allclose(sight.target.truth, settled.loop.target.position(sight.time))
    np.testing.assert_allclose(sight.target.velocity, [3.0, 0.0, 0.0], atol=0.2)
    assert ask(change, SIMULATOR, wind=[0.0, 0.0, 0.0]) == ""
    assert ask(change, TARGET, motion="stationary") == ""


def during(settled, fault):
    """Sights of a fault, after which the aircraft comes back to its orbit by itself."""
    assert settled.ask(settled.steering.inject, fault) == ""
    sights = settled.fly(DURATIONS[fault])
    after = settled.fly(15.0)
    assert after[-1].mode is FallbackMode.OPTIMAL
    assert after[-1].reason == ""
    assert circles(after[-20:])
    return sights


def test_a_target_that_is_lost_is_circled_by_the_loiter_law(settled):
    sights = during(settled, TARGET_LOST)
    assert sights[-1].mode is FallbackMode.LOITER
    assert sights[-1].reason == "target position is lost"
    assert sights[-1].target.std > sights[0].target.std


def test_without_states_the_plan_is_flown_to_its_end_and_then_wings_level(settled):
    failsafes = settled.loop.plant.plan.failsafes
    sights = during(settled, STATE_LOST)
    assert sights[-1].mode is FallbackMode.SILENCE
    assert "vehicle state is lost" in sights[-1].reason
    lengths = [len(sight.plan) for sight in sights if sight.plan is not None]
    assert lengths == sorted(lengths, reverse=True)
    assert sights[-1].plan is None
    assert abs(sights[-1].bank) < 0.05
    assert settled.loop.plant.plan.failsafes == failsafes + 1


def test_a_controller_that_is_killed_answers_nothing_and_starts_with_its_first_parameters(settled):
    first, dead = settled.loop.configuration.controller, settled.loop.controller
    assert settled.ask(settled.steering.change, CONTROLLER, range=310.0) == ""
    settled.ask(settled.steering.inject, CONTROLLER_KILLED)
    killed = "the controller was killed"
    assert settled.ask(settled.steering.change, CONTROLLER, range=320.0) == killed
    assert settled.ask(settled.steering.engage, True) == killed
    sights = during(settled, CONTROLLER_KILLED)
    assert {(sight.mode, sight.reason) for sight in sights} == {(FallbackMode.SILENCE, killed)}
    assert settled.loop.controller is not dead
    assert settled.loop.controller.parameters == first


def test_a_controller_that_is_disengaged_is_silent_until_it_is_engaged(settled):
    assert settled.ask(settled.steering.engage, False) == ""
    silent = settled.fly(1.0)
    assert {sight.mode for sight in silent} == {FallbackMode.SILENCE}
    assert settled.ask(settled.steering.engage, True) == ""
    assert settled.fly(1.0)[-1].mode is FallbackMode.OPTIMAL


def test_a_reset_puts_the_aircraft_back_and_time_goes_on(settled):
    begin = settled.loop.time
    assert settled.ask(settled.steering.reset) == ""
    sights = settled.fly(45.0)
    assert sights[0].time == pytest.approx(begin)
    start = settled.loop.configuration.simulator.initial_position
    np.testing.assert_allclose(sights[0].position, start)
    assert sights[-1].mode is FallbackMode.OPTIMAL
    assert circles(sights[-20:])


def test_a_paused_flight_stands_still_and_goes_on_from_there(settled):
    assert settled.ask(settled.steering.pause, True) == ""
    time, sight = settled.loop.time, settled.flight.sight
    settled.wait(30.0)
    assert settled.loop.time == time
    assert settled.flight.sight is sight
    assert settled.ask(settled.steering.change, SIMULATOR, speed=4.0) == ""
    settled.wait(30.0)
    assert settled.loop.time == time
    assert settled.ask(settled.steering.pause, False) == ""
    settled.wait(1.0)
    assert settled.loop.time == pytest.approx(time + 4.0, abs=0.1)


def test_what_is_changed_while_time_stands_is_seen_at_once(settled):
    settled.fly(1.0)
    assert settled.ask(settled.steering.pause, True) == ""
    before = settled.flight.sight
    assert settled.ask(settled.steering.change, CONTROLLER, range=350.0) == ""
    longer = settled.flight.sight.errors["range_error"] - before.errors["range_error"]
    assert longer == pytest.approx(-50.0, abs=1.0)
    assert settled.ask(settled.steering.engage, False) == ""
    assert settled.flight.sight.mode is FallbackMode.SILENCE
    assert settled.ask(settled.steering.reset) == ""
    start = settled.loop.configuration.simulator.initial_position
    np.testing.assert_allclose(settled.flight.sight.position, start)
    assert settled.flight.sight.time == settled.loop.time
    assert settled.ask(settled.steering.engage, True) == ""
    assert settled.ask(settled.steering.pause, False) == ""
    assert settled.fly(1.0)[-1].mode is FallbackMode.OPTIMAL
