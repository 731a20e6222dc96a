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

"""A simulation that is watched: its pace, what there is to see of it, what is left of it."""

import math
import sys
import threading

import numpy as np
import pytest
from stepped_simulation import LONG_ENOUGH, SteppedSimulation

from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.closed_loop import simulate
from uav_tracking_mpc.view.simulated import simulated_source
from uav_tracking_mpc.view.simulated.simulated_source import MOST_BEHIND, SimulatedSource
from uav_tracking_mpc.view.steering import SIMULATOR

LAW = "nmpc_controller.law=l1"  # quick to fly


@pytest.fixture(scope="module")
def flown():
    simulation = SteppedSimulation(scenario="wind")
    return simulation, simulation.fly(30.0)


def test_it_is_the_flight_of_simulate(flown):
    """Bit for bit: watching changes nothing."""
    simulation, _ = flown
    overrides = [LONG_ENOUGH, "mission.duration=30"]
    plain = simulate(load_configuration("small_uav", overrides, "wind"))
    watched = simulation.loop.log(30.0)
    np.testing.assert_array_equal(watched.time, plain.time)
    np.testing.assert_array_equal(watched.vehicle, plain.vehicle)
    np.testing.assert_array_equal(watched.inputs, plain.inputs)
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
    monkeypatch.setattr(simulated_source, "PAST_SPAN", 20.0)
    simulation = SteppedSimulation(LAW)
    simulation.fly(40.0)
    past = simulation.flight.past(1e9)
    assert len(past) == 100
    assert past[-1].time - past[0].time == pytest.approx(19.8)
    recent = simulation.flight.past(5.0)
    assert recent == past[-26:]
    assert past[0].plan is None


@pytest.mark.parametrize("speed", [0.5, 8.0])
def test_it_keeps_its_pace_without_drift(speed):
    """However irregular the thread runs, as long as it is not far behind."""
    simulation = SteppedSimulation(LAW, f"mission.speed={speed}")
    period, rng = 1.0 / simulation.loop.rate, np.random.default_rng(1)
    while simulation.wall < 5.0:
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
    assert log.duration == pytest.approx(time + 0.05)
    assert log.speed == 100.0


def test_the_log_of_an_hour_is_small():
    """16 numbers a state and 7 a command, 20 of each a second."""
    simulation = SteppedSimulation(LAW)
    simulation.fly(20.0)
    recorder = simulation.loop._recorder
    arrays = [value for value in vars(recorder).values() if hasattr(value, "buffer_info")]
    held = sum(len(column) * column.itemsize for column in arrays)
    assert held / 20.0 * 3600.0 < 14e6
    assert sum(map(sys.getsizeof, arrays)) < 2 * held
