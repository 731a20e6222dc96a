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

import time
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.studies.faults.kinds.kill import RESTART_LIMIT, Kill


@pytest.fixture
def flight():
    calls = []
    supervisor = SimpleNamespace(
        kill=lambda name: calls.append(("kill", name)),
        restart=lambda name: calls.append(("restart", name)),
    )
    return SimpleNamespace(
        supervisor=supervisor, observer=SimpleNamespace(heard={"b": 50.0}), calls=calls
    )


def test_a_killed_node_is_started_and_must_be_heard_again(flight, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    fault = Kill("b")
    fault.begin(flight, 0.5, 0)
    fault.end(flight)
    assert flight.calls == [("kill", "b"), ("restart", "b")]
    assert not fault.settled(flight)
    assert fault.violations(flight) == []
    now[0] += RESTART_LIMIT + 1.0
    assert fault.settled(flight)
    assert [violation.invariant for violation in fault.violations(flight)] == ["restart"]
    now[0] -= 10.0
    flight.observer.heard["b"] = 101.0
    assert fault.settled(flight)
    assert fault.violations(flight) == []
