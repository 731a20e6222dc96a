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

"""Every stream has a sender among the nodes of a flight, or nothing would go through the relay."""

import pytest

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.streams import STREAMS


@pytest.mark.parametrize("topic", STREAMS, ids=lambda topic: topic.name)
def test_one_node_of_a_flight_sends_it(topic):
    assert sum(node in topic.sender for node in NODES) == 1
