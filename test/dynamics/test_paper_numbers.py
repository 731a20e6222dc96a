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

"""The numbers of the paper are the same wherever they are said."""

import numpy as np
import pytest

from uav_tracking_mpc.dynamics import paper_numbers as paper
from uav_tracking_mpc.dynamics.relative import relative_state
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.settings.simulator import SimulatorParameters
from uav_tracking_mpc.settings.tracking import TrackingParameters


def of_controller(values):
    return {
        "orbit": (values.orbit.range, values.orbit.altitude, values.orbit.speed),
        "direction": values.direction,
        "step": values.horizon_step,
        "horizon": values.horizon,
        "state weights": values.state_weights,
        "input weights": values.input_weights,
        "scaling": values.terminal_scaling,
        "lower": tuple(values.input_lower),
        "upper": tuple(values.input_upper),
    }


PRINTED = {
    "orbit": (paper.ORBIT.range, paper.ORBIT.altitude, paper.ORBIT.speed),
    "direction": paper.ORBIT.direction,
    "step": paper.STEP,
    "horizon": paper.HORIZON,
    "state weights": paper.STATE_WEIGHTS,
    "input weights": paper.INPUT_WEIGHTS,
    "scaling": paper.SCALING,
    "lower": tuple(-bound for bound in paper.INPUT_BOUNDS),
    "upper": paper.INPUT_BOUNDS,
}


def test_defaults_of_the_controller():
    assert of_controller(TrackingParameters()) == PRINTED


def test_configuration_paper():
    configuration = load_configuration("paper")
    assert of_controller(configuration.controller) == PRINTED
    assert configuration.mission.duration == paper.DURATION
    start = relative_state(configuration.simulator.initial_state, configuration.target.position)
    assert start == pytest.approx(paper.INITIAL_STATE, rel=1e-15, abs=1e-15)


def test_default_start_of_the_simulator():
    start = relative_state(SimulatorParameters().initial_state, np.zeros(3))
    assert start == pytest.approx(paper.INITIAL_STATE, rel=1e-15, abs=1e-15)
