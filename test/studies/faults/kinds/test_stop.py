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

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.kinds.stop import Stop


def test_a_frozen_node_goes_on():
    calls = []
    supervisor = SimpleNamespace(
        freeze=lambda name: calls.append(("freeze", name)),
        thaw=lambda name: calls.append(("thaw", name)),
    )
    flight = SimpleNamespace(supervisor=supervisor)
    for fault in Stop.variants():
        fault.begin(flight, 1.0, 0)
        fault.end(flight)
    assert calls == [(action, node) for node in NODES for action in ("freeze", "thaw")]
