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

import collections

import numpy as np
import pytest

from uav_tracking_mpc.control.controller import Controller
from uav_tracking_mpc.links import LinkError
from uav_tracking_mpc.links.simulated import SimulatedLink
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters

CRUISE = SimulatorParameters(initial_speed=15.0, initial_path_angle=0.2, speed_max=40.0)


def test_it_flies_the_last_plan_to_its_end_then_holds_the_wings_level_as_it_says():
    with SimulatedLink(parameters=CRUISE) as link:
        assert link.command(link.now(), np.array([[0.2, 0.0, 0.0]] * 4), 0.5) == ""
        states = [link.measured(1.0) for _ in range(400)]
    np.testing.assert_allclose([state.stamp for state in states[:3]], [0.05, 0.10, 0.15])
    assert states[20].turn_rate == pytest.approx(0.2)
    assert states[20].heading - states[0].heading == pytest.approx(0.2)
    assert (states[-1].turn_rate, states[-1].path_angle) == pytest.approx((0.0, 0.0), abs=1e-4)
    assert "wings level" in SimulatedLink.when_silent


def test_what_cannot_be_flown_is_refused_in_words():
    with SimulatedLink(parameters=CRUISE) as link:
        assert "not finite" in link.command(0.0, np.full((1, 3), np.nan), 0.5)
        assert "begins 60.000 s from now" in link.command(60.0, np.zeros((1, 3)), 0.5)


def test_a_plant_that_does_not_exist_is_no_aircraft():
    with pytest.raises(LinkError, match="plant is 'balloon', must be one of euler, .*vehicle"):
        SimulatedLink("balloon").connect(1.0)
    with pytest.raises(LinkError, match="not connected"):
        SimulatedLink().measured(1.0)


def test_an_aircraft_that_is_lost_is_said():
    """The Euler plant, flown level at its target, meets a point where it has no value."""
    start = SimulatorParameters(
        initial_position=(30.0, 0.0, 20.0), initial_speed=10.0, initial_heading=np.pi
    )
    with SimulatedLink("euler", start) as link, pytest.raises(LinkError, match="is lost: at"):
        collections.deque((link.measured(1.0) for _ in range(200)), maxlen=0)


def test_a_loop_of_ones_own_flies_onto_the_orbit():
    """Nothing but the link and the controller, as a user would write it."""
    configuration = load_configuration("small_uav", ["nmpc_controller.solve_time_max=5.0"])
    controller = Controller(configuration.controller, stopwatch=lambda: 0.0)
    target, distances = np.zeros(3), []
    with SimulatedLink(parameters=configuration.simulator) as link:
        while link.now() < 40.0:
            state = link.measured(1.0)
            controller.see_target(state.stamp, target)
            command = controller.step(state, link.now())
            if command is not None:
                assert link.command(command.stamp, command.inputs, command.step) == ""
            distances.append(np.linalg.norm(state.position - target))
    assert distances[0] > 590.0
    assert np.max(np.abs(np.array(distances[-200:]) - 300.0)) < 1.0
