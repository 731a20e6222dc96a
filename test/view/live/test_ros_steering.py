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

"""What a page asks of ROS nodes, and what it is told where they refuse."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from answering_node import AnsweringNode

from uav_tracking_mpc.nodes.target_truth import goal_from_point, set_truth
from uav_tracking_mpc.nodes.topics import TARGET_TRUTH
from uav_tracking_mpc.view.live.ros_steering import FAULTS, RosSteering
from uav_tracking_mpc.view.steering import CONTROLLER, SIMULATOR, TARGET

SHORT = "parameter 'range' is 20.0, must be at least 40 m: the bank limit"
DONE = SimpleNamespace(success=True, message="done")


@pytest.fixture
def node():
    """All three nodes of one of several aircraft."""
    node = AnsweringNode("/uav1")
    values = {"range": 300.0, "direction": "nearest", "autostart": True, "horizon": 20}
    node.own(CONTROLLER, values, lambda wanted: SHORT if wanted.get("range") == 20.0 else "")
    node.own(SIMULATOR, {"wind": [0.0, 0.0, 0.0]})
    node.target = {"motion": "circle", "position": [0.0, 0.0, 0.0]}
    node.own(TARGET, node.target)
    return node


@pytest.fixture
def steering(node):
    return RosSteering(node, "uav1")


def tell_truth(node, position):
    message = TARGET_TRUTH.type()
    set_truth(message, 0, np.array(position), np.zeros(3))
    node.heard["/uav1/target/truth"](message)


def test_only_who_is_there_is_steered(node, steering):
    assert steering.nodes == {CONTROLLER, SIMULATOR, TARGET}
    for owner in (SIMULATOR, TARGET):  # as with a real autopilot and a tracker
        node.answers = {k: v for k, v in node.answers.items() if owner not in k}
    steering = RosSteering(node, "/uav1/")
    assert steering.nodes == {CONTROLLER}
    assert steering.change(SIMULATOR, wind=(1.0, 0.0, 0.0)) == "uav_simulator is not there"
    assert steering.pause(True) == "uav_simulator is not there"
    assert steering.reset() == "uav_simulator is not there"
    assert steering.parameters(SIMULATOR) == {}


def test_aircraft_of_another_namespace_are_not_asked(node):
    assert RosSteering(node, "uav2").nodes == frozenset()
    assert RosSteering(node, "").nodes == frozenset()


def test_parameters_are_read_and_changed(steering):
    found = steering.parameters(CONTROLLER)
    assert found == {"range": 300.0, "direction": "nearest", "autostart": True, "horizon": 20}
    assert steering.change(CONTROLLER, range=350.0, direction="clockwise", horizon=22) == ""
    assert steering.parameters(CONTROLLER)["range"] == 350.0
    assert steering.parameters(CONTROLLER)["direction"] == "clockwise"
    for wind in ((6, 0.0, 0), np.array([6.0, 0.0, 0.0])):  # as sliders and arrays give them
        assert steering.change(SIMULATOR, wind=wind) == ""
        assert list(steering.parameters(SIMULATOR)["wind"]) == [6.0, 0.0, 0.0]
    assert steering.change(CONTROLLER, range=np.float64(320.0)) == ""
    assert steering.parameters(CONTROLLER)["range"] == 320.0


def test_a_refusal_is_the_nodes_own_words(steering):
    assert steering.change(CONTROLLER, range=20.0, direction="clockwise") == SHORT
    assert steering.parameters(CONTROLLER)["direction"] == "nearest"


def test_a_node_that_does_not_answer_is_a_refusal(node, steering):
    node.offer("nmpc_controller/engage", lambda request: DONE)
    assert steering.engage(False) == ""
    node.fall_silent(CONTROLLER)
    words = "nmpc_controller did not answer within 5 s"
    assert steering.change(CONTROLLER, range=350.0) == words
    assert steering.engage(True) == words
    assert steering.parameters(CONTROLLER) == {}
    assert steering.change(SIMULATOR, wind=(1.0, 0.0, 0.0)) == ""  # the others are as before


def test_services_are_called_as_asked_and_refuse_in_their_own_words(node, steering):
    asked = []

    def answered(request):
        asked.append(getattr(request, "data", None))
        return DONE

    for service in ("nmpc_controller/engage", "uav_simulator/pause", "uav_simulator/reset"):
        node.offer(service, answered)
    answers = [steering.engage(False), steering.pause(True), steering.pause(False)]
    assert [*answers, steering.reset()] == ["", "", "", ""]
    assert asked == [False, True, False, None]
    words = "time is the wall's and cannot be stopped"
    node.offer("uav_simulator/pause", lambda request: SimpleNamespace(success=False, message=words))
    assert steering.pause(True) == words


def test_the_target_is_sent_at_the_height_that_it_has(node, steering):
    assert steering.send_target(10.0, 20.0) == "target_publisher has not told where the target is"
    tell_truth(node, (1.0, 2.0, 30.0))
    assert steering.send_target(10.0, 20.0) == ""
    ((topic, message),) = node.published
    assert topic == "/uav1/target/goal"
    np.testing.assert_array_equal(goal_from_point(message), [10.0, 20.0, 30.0])
    assert node.target == {"motion": "stationary", "position": [10.0, 20.0, 30.0]}


def test_a_goal_that_is_not_taken_is_told(node, steering):
    tell_truth(node, (0.0, 0.0, 0.0))
    assert "must be finite" in steering.send_target(math.nan, 0.0)
    assert node.published == []
    words = "parameter 'position' is [2e+06, 0, 0], must be a list of 3 numbers"
    node.own(TARGET, node.target, lambda wanted: words)
    assert steering.send_target(2e6, 0.0) == words
    node.fall_silent(TARGET)
    assert steering.send_target(1.0, 0.0) == "target_publisher did not answer within 5 s"


def test_faults_are_those_that_are_offered(node, steering):
    assert steering.faults == {}
    assert steering.inject("controller killed") == (
        "fault 'controller killed' is not offered here; offered: none"
    )
    called = []

    def answer(service):
        return lambda request: called.append(service) or DONE

    for service, _ in FAULTS.values():
        node.offer(service, answer(service))
    assert list(steering.faults) == ["target lost", "state lost", "controller killed"]
    assert [steering.inject(fault) for fault in steering.faults] == ["", "", ""]
    assert called == [service for service, _ in FAULTS.values()]
    assert "offered: target lost, state lost" in steering.inject("meteorite")
