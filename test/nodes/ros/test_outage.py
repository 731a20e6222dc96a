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

"""What a node keeps back is sent again after 15 s of its time, whoever asked for the outage."""

from types import SimpleNamespace

import pytest
from std_srvs.srv import Trigger

from uav_tracking_mpc.nodes.ros.endpoints import OUTAGE, SimulatedOutage


@pytest.fixture
def node():
    node = SimpleNamespace(time=100.0, services={}, told=[])
    node.create_service = lambda kind, name, call: node.services.update({name: call})
    node.get_logger = lambda: SimpleNamespace(info=node.told.append)
    node.outage = SimulatedOutage(node, "lose_state", "the state", lambda: node.time)
    node.ask = lambda: node.services["~/lose_state"](Trigger.Request(), Trigger.Response())
    return node


def test_it_begins_when_it_is_asked_for_and_ends_by_itself(node):
    assert not node.outage.lasts
    answer = node.ask()
    assert answer.success
    assert answer.message == "the state is kept back for 15 s by the service lose_state"
    assert node.told == [f"lose_state: {answer.message}"]
    assert node.outage.lasts
    node.time += OUTAGE - 1e-6
    assert node.outage.lasts
    node.time += 2e-6
    assert not node.outage.lasts


def test_asked_again_it_lasts_from_then_on(node):
    node.ask()
    node.time += 10.0
    node.ask()
    node.time += 10.0
    assert node.outage.lasts
    node.time += OUTAGE - 10.0
    assert not node.outage.lasts


def test_it_is_over_where_time_goes_back(node):
    node.ask()
    node.time = 0.0
    assert not node.outage.lasts
