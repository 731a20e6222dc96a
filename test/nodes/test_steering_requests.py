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

"""Requests to nodes: what they cost the nodes, and what is sent."""

import pytest
from heard_flight import AnsweringNode
from rcl_interfaces.msg import ParameterEvent

from uav_tracking_mpc.nodes.watching import NoAnswerError, SteeringRequests


@pytest.fixture
def node():
    node = AnsweringNode("/red")
    node.values = {"range": 300.0, "wind": [0.0, 1.0, 0.0], "names": ["a", "b"]}
    node.own("nmpc_controller", node.values)
    return node


@pytest.fixture
def requests(node):
    return SteeringRequests(node, "/red", ("nmpc_controller",), (), ())


def changed(node, name):
    node.heard["/parameter_events"](ParameterEvent(node=name))


def test_a_node_is_asked_again_only_when_its_parameters_have_changed(node, requests):
    assert requests.parameters("nmpc_controller")["range"] == 300.0
    asked = len(node.asked)
    changed(node, "/blue/nmpc_controller")
    assert requests.parameters("nmpc_controller")["range"] == 300.0
    assert len(node.asked) == asked
    node.values["range"] = 310.0
    changed(node, "/red/nmpc_controller")
    assert requests.parameters("nmpc_controller")["range"] == 310.0
    assert requests.change("nmpc_controller", {"range": 320.0}) == ""
    assert requests.parameters("nmpc_controller")["range"] == 320.0


def test_what_is_returned_is_the_callers(requests):
    requests.parameters("nmpc_controller")["range"] = 0.0
    assert requests.parameters("nmpc_controller")["range"] == 300.0


def test_what_changes_while_it_is_asked_for_is_asked_for_again(node, requests):
    service = "/red/nmpc_controller/get_parameters"
    answer = node.answers[service]

    def changing(request):
        said = answer(request)
        node.values["range"] = 310.0
        changed(node, "/red/nmpc_controller")
        node.answers[service] = answer
        return said

    node.answers[service] = changing
    assert requests.parameters("nmpc_controller")["range"] == 300.0
    assert requests.parameters("nmpc_controller")["range"] == 310.0


def test_a_node_that_has_gone_has_no_parameters(node, requests):
    assert requests.parameters("nmpc_controller")
    node.answers.clear()
    with pytest.raises(NoAnswerError, match="nmpc_controller is not there"):
        requests.parameters("nmpc_controller")
