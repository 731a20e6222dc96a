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

"""Where commands say that they lead, against where they do."""

from dataclasses import replace

import numpy as np
import pytest
import small_uav

from uav_tracking_mpc.control.commanded_path import CommandPaths
from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.control.fallback import FallbackMode
from uav_tracking_mpc.estimation.measurement import Measurement
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.simulation.plants import plant_of

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
    path = paths.path(controller, seen, replace(command, present=broken))
    assert np.isfinite(path.states).all()
    np.testing.assert_array_equal(path.states[0, :3], seen.position)
