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

"""Parameters of the controller that are set while it flies."""

from __future__ import annotations

import numpy as np
import pytest
from node_flight import Flight

from uav_tracking_mpc.nodes.nmpc_controller import NmpcController

pytestmark = pytest.mark.nodes


@pytest.fixture
def flight():
    flight = Flight()
    yield flight
    flight.end()


def test_another_orbit_is_flown_without_a_jump(flight):
    flight.add_all()
    assert flight.commanded(40)
    assert flight.spin(lambda: flight.told()[1].get("mode") == "optimal plan")
    begin = len(flight.commands)
    assert flight.set(range=340.0, altitude=140.0).successful
    assert flight.controller.parameters.orbit.range == 340.0
    assert flight.commanded(60)
    steps = np.abs(np.diff(flight.inputs()[begin - 1 :], axis=0))
    # Full bank the other way is what the new orbit asks for: half a second is spent on it.
    limit = flight.controller.parameters.envelope.turn_rate_max(22.0)
    assert np.max(steps[:, 0]) < 0.5 * limit
    assert np.max(steps[:, 1]) < 0.25
    assert np.max(steps[:, 2]) < 2.5
    assert flight.told()[1]["mode"] == "optimal plan"
    # It climbs and widens.
    assert flight.spin(lambda: flight.states[-1].pose.pose.position.z > 125.0)


def test_what_is_refused_leaves_everything_as_it_was(flight):
    flight.add_all()
    assert flight.commanded()
    before, orbit = flight.controller.parameters, flight.controller.controller.orbit
    for values, words in (
        ({"range": 125.0}, "the nearest orbit that can be flown has a range of"),
        ({"airspeed": 31.9, "range": 140.0, "altitude": 110.0}, "nearest orbit"),
        ({"target_noise": 0.5, "range": 310.0, "airspeed": 40.0}, "airspeed"),
        ({"target_noise": 0.5, "horizon": 30}, "'horizon' is 30"),
        ({"range": 310.0, "altitude": float("nan")}, "altitude"),
        ({"range": 310.0, "no_such_parameter": 1.0}, "undeclared"),
    ):
        answer = flight.set(**values)
        assert not answer.successful, values
        assert words in answer.reason, answer.reason
        assert flight.controller.parameters == before
        assert flight.controller.controller.orbit == orbit
        for name in values:
            if hasattr(before, name):
                assert flight.controller.get_parameter(name).value == getattr(before, name)
    assert flight.commanded()
    assert flight.told()[1]["mode"] == "optimal plan"


def test_the_paper_takes_a_new_orbit():
    flight = Flight("paper")
    try:
        flight.add_all()
        assert flight.commanded()
        before = flight.told()[1]["terminal set"]
        assert flight.set(range=350.0, direction="counter_clockwise").successful  # as in the README
        assert flight.commanded(20)
        assert flight.told()[1]["mode"] == "optimal plan"
        assert flight.told()[1]["direction"] == "counter_clockwise"
        assert before == "neither: no terminal set is flown"
        assert flight.spin(lambda: flight.told()[1]["terminal set"] == before)
        answer = flight.set(range=51.0, altitude=50.0, airspeed=19.0)
        assert not answer.successful
        assert "must exceed" in answer.reason
        answer = flight.set(state_weights=[1.0] * 5)
        assert not answer.successful
        assert "in flight unless terminal_constraint is 'artificial_orbit'" in answer.reason
        assert flight.commanded()
    finally:
        flight.end()


def test_a_lower_control_rate_is_no_rate_that_is_not_kept(flight):
    flight.add_all(speed=None)
    assert flight.commanded()
    assert flight.set(control_rate=5.0).successful
    flight.spin(lambda: False, 1.0)
    before = flight.controller.report.deadlines_missed
    assert flight.commanded(10)
    assert flight.controller.report.deadlines_missed == before


def test_lag_dead_time_and_budget_change_in_flight(flight):
    flight.add_all()
    assert flight.commanded()
    wanted = {"rate_lag": [0.3, 0.3, 0.2], "dead_time": [0.1, 0.2, 0.2], "solve_time_max": 0.9}
    assert flight.set(**wanted).successful
    assert flight.commanded(20)
    assert flight.told()[1]["mode"] == "optimal plan"
    assert flight.controller.controller.formulation.solver.time_limit == 0.9
    assert flight.controller.parameters.rate_lag == (0.3, 0.3, 0.2)


def test_small_margins_are_told_at_configuration_and_after_a_change(flight):
    controller = flight.add(NmpcController, "controller", gain_margin_min=60.0)

    def told():
        controller._margins.wait()
        return [words for _, words in controller.controller.events.take()]

    assert any("gain_margin_min is 60 dB" in words for words in told())
    assert flight.set(gain_margin_min=6.0).successful
    assert not any("margin" in words for words in told())
    assert flight.set(input_weights=[0.04] * 3, rate_weights=[0.0] * 3).successful
    assert any("turn bears 0." in words for words in told())
