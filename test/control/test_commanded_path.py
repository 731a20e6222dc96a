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

"""Paths against the vehicle's exact motion and against a fine integration of its response."""

from dataclasses import replace

import numpy as np
import pytest
import small_uav
from hypothesis import given
from hypothesis import strategies as st

from uav_tracking_mpc.control.commanded_path import CommandPaths
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.dynamics import vehicle
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.plants import plant_of

START = np.array([100.0, -50.0, 120.0, 2.5, 0.1, 22.0])
WIND, AT_ONCE = np.array([5.0, -3.0, 0.5]), np.zeros(3)
RATES = np.array([0.2, -0.05, 0.3])
STEP = 0.5  # s


def plan(count, seed=0):
    random = np.random.default_rng(seed)
    return random.uniform(-1.0, 1.0, size=(count, 3)) * (0.5, 0.1, 1.0)


@pytest.mark.parametrize("count", [1, 2, 20])
def test_without_a_lag_it_is_the_vehicles_motion_in_moving_air(count):
    inputs = plan(count)
    path = CommandPaths().planned(START, RATES, WIND, inputs, STEP, AT_ONCE, AT_ONCE)
    state, drift = START, np.zeros(3)
    for stage in range(count + 1):
        found = path.states[stage]
        np.testing.assert_allclose(found[:3], state[:3] + drift, atol=1e-3)
        np.testing.assert_allclose(np.cos(found[3:5]), np.cos(state[3:5]), atol=1e-9)
        assert found[5] == pytest.approx(state[5])
        ground = vehicle.velocity(state) + WIND
        np.testing.assert_allclose(path.ground_velocities[stage], ground, atol=1e-9)
        if stage < count:
            state, drift = vehicle.advance(state, inputs[stage], STEP), drift + STEP * WIND


def test_lag_and_dead_time_are_flown_through():
    lags, dead_times = np.array([0.3, 0.13, 0.0]), np.array([0.17, 0.2, 0.6])
    inputs, fine = plan(8), 1000
    path = CommandPaths().planned(START, RATES, WIND, inputs, STEP, lags, dead_times)
    state, rates, position = START[3:].copy(), RATES.copy(), START[:3].copy()
    small = STEP / fine
    for tick in range(len(inputs) * fine):
        if tick % fine == 0:
            found = path.states[tick // fine]
            np.testing.assert_allclose(found[3:], state, atol=2e-3)
            np.testing.assert_allclose(found[:3], position, atol=0.2)
        middle = (tick + 0.5) * small
        for axis in range(3):
            if middle >= dead_times[axis]:
                wanted = inputs[int((middle - dead_times[axis]) / STEP), axis]
                share = -np.expm1(-small / lags[axis]) if lags[axis] else 1.0
                rates[axis] += share * (wanted - rates[axis])
        half = state + 0.5 * small * rates
        position += small * (vehicle.velocity([0.0, 0.0, 0.0, *half]) + WIND)
        state += small * rates


def test_velocities_are_the_slope_of_the_positions():
    lags = np.full(3, 0.3)
    path = CommandPaths().planned(START, RATES, WIND, plan(40), 0.02, lags, AT_ONCE)
    slopes = (path.states[2:, :3] - path.states[:-2, :3]) / 0.04
    np.testing.assert_allclose(path.ground_velocities[1:-1], slopes, atol=0.02)


def test_it_begins_where_the_aircraft_is_and_as_it_flies():
    path = CommandPaths().planned(START, RATES, WIND, plan(5), STEP, np.ones(3), np.ones(3))
    np.testing.assert_array_equal(path.states[0], START)
    np.testing.assert_allclose(path.ground_velocities[0], vehicle.velocity(START) + WIND)


def test_one_planner_takes_plans_of_any_form():
    planner = CommandPaths()
    for count, step, lag in ((5, 0.5, 0.0), (1, 1.0, 0.3), (5, 0.5, 0.0), (5, 0.4, 0.2)):
        arguments = START, RATES, WIND, plan(count), step, np.full(3, lag), AT_ONCE
        first, alone = planner.planned(*arguments), CommandPaths().planned(*arguments)
        np.testing.assert_array_equal(first.states, alone.states)
        again = planner.planned(START + 1.0, *arguments[1:])
        assert not np.array_equal(again.states, first.states)  # what was given out stays
        np.testing.assert_array_equal(first.states, alone.states)


@given(st.lists(st.tuples(*[st.floats(-10.0, 10.0)] * 3), min_size=1, max_size=30))
def test_of_finite_inputs_it_is_finite(inputs):
    path = CommandPaths().planned(
        START, RATES, WIND, np.array(inputs), 1.0, np.full(3, 1e-9), AT_ONCE
    )
    assert np.isfinite(path.states).all()
    assert np.isfinite(path.ground_velocities).all()


CONFIGURATION = load_configuration("small_uav", [small_uav.PATIENT], "wind")


@pytest.fixture(scope="module")
def flight():
    """Measurements, commands and paths of a flight in wind, and where the aircraft then was."""
    plant, controller = plant_of(CONFIGURATION), Controller(CONFIGURATION.controller)
    paths, flown, period = CommandPaths(), [], 1.0 / CONFIGURATION.simulator.state_rate
    for tick in range(round(60.0 / period)):
        now = plant.time = tick * period
        controller.see_target(now, CONFIGURATION.target.position)
        measured = plant.measured()
        command = controller.step(measured, now)
        path = None
        if command is not None:
            path = paths.path(controller, measured, command)
            plant.accept(command.inputs, now + command.step * np.arange(len(command.inputs)))
        flown.append((now, plant.truth, command, path))
        plant.advance(period)
    return flown


def test_it_begins_at_the_state_that_is_answered(flight):
    for _, truth, command, path in flight:
        if command is not None:
            np.testing.assert_allclose(path.states[0, :3], truth.position, atol=0.5)
            np.testing.assert_allclose(path.ground_velocities[0], truth.ground_velocity, atol=1.0)


def test_the_aircraft_comes_where_it_leads(flight):
    """Over three seconds of the settled orbit, by feedback and in wind that is not known."""
    positions = np.array([truth.position for _, truth, _, _ in flight])
    times = np.array([time for time, *_ in flight])
    off = []
    for time, _, command, path in flight[len(flight) // 2 : -len(flight) // 10]:
        if command is not None:
            stage = round(3.0 / command.step)
            at = time + stage * command.step
            there = [np.interp(at, times, axis) for axis in positions.T]
            off.append(np.linalg.norm(path.states[stage, :3] - there))
    assert np.median(off) < 2.0  # of 66 m that are flown
    assert max(off) < 5.0


def test_of_a_law_and_without_a_target_it_is_there_as_well():
    parameters = replace(CONFIGURATION.controller, law="l1")
    controller, paths = Controller(parameters), CommandPaths()
    ground = np.array([20.0, 4.0, 0.5])
    seen = Measurement(0.0, np.array([300.0, 0.0, 120.0]), ground, 0.1, 0.0, airspeed=22.0)
    controller.see_target(0.0, np.zeros(3))
    command = controller.step(seen, 0.0)
    path = paths.path(controller, seen, command)
    assert len(path.states) == len(command.inputs) + 1 == 2
    np.testing.assert_allclose(path.ground_velocities[0], ground, atol=0.2)  # filtered
    controller.navigator.target.reset()
    later = replace(seen, stamp=0.1)
    command = controller.step(later, 0.1)
    assert command.mode is FallbackMode.HOLD
    path = paths.path(controller, later, command)
    np.testing.assert_array_equal(path.states[0, :3], seen.position)
    np.testing.assert_allclose(path.ground_velocities[0], ground)


def test_a_situation_that_is_not_finite_leaves_the_measurement():
    controller, paths = Controller(replace(CONFIGURATION.controller, law="l1")), CommandPaths()
    place, ground = np.array([300.0, 0.0, 120.0]), np.array([20.0, 4.0, 0.5])
    seen = Measurement(0.0, place, ground, 0.1, 0.0, airspeed=20.0)
    controller.see_target(0.0, np.zeros(3))
    command = controller.step(seen, 0.0)
    broken = replace(command.present, vehicle=np.full(6, np.nan))
    path = paths.path(controller, seen, command._replace(present=broken))
    assert np.isfinite(path.states).all()
    np.testing.assert_array_equal(path.states[0, :3], seen.position)
