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

import os
import time
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.studies.faults.kinds.process import (
    PER_CORE,
    RESTART_LIMIT,
    CpuStarvation,
    Kill,
    Stop,
)


class Calls:
    """A supervisor that writes down what it is asked for."""

    def __init__(self):
        self.made = []

    def __getattr__(self, action):
        return lambda name: self.made.append((action, name))


@pytest.fixture
def flight():
    return SimpleNamespace(supervisor=Calls(), observer=SimpleNamespace(heard={"b": 50.0}))


def test_a_killed_node_is_started_and_must_be_heard_again(flight, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    fault = Kill("b")
    fault.begin(flight, 0.5, 0)
    fault.end(flight)
    assert flight.supervisor.made == [("kill", "b"), ("restart", "b")]
    assert not fault.settled(flight)
    assert fault.violations(flight) == []
    now[0] += RESTART_LIMIT + 1.0
    assert fault.settled(flight)
    assert [violation.invariant for violation in fault.violations(flight)] == ["restart"]
    now[0] -= 10.0
    flight.observer.heard["b"] = 101.0
    assert fault.settled(flight)
    assert fault.violations(flight) == []


def test_a_frozen_node_goes_on(flight):
    for fault in Stop.variants():
        fault.begin(flight, 1.0, 0)
        fault.end(flight)
    frozen = [(action, node) for node in NODES for action in ("freeze", "thaw")]
    assert flight.supervisor.made == frozen


def test_busy_processes_are_ended():
    fault = CpuStarvation()
    fault.begin(None, 1.0, 0)
    busy = fault._busy
    assert len(busy) == PER_CORE * os.cpu_count()
    assert all(process.poll() is None for process in busy)
    fault.end(None)
    assert all(process.poll() is not None for process in busy)
