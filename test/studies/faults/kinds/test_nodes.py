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
import random
import time
from types import SimpleNamespace
from unittest.mock import Mock, call

import pytest

pytest.importorskip("rclpy")

from uav_tracking_mpc.launch.supervisor import NODES
from uav_tracking_mpc.parameters.specification import specifications
from uav_tracking_mpc.settings.tracking import TrackingParameters
from uav_tracking_mpc.studies.faults.kinds import nodes
from uav_tracking_mpc.studies.faults.kinds.nodes import (
    LIMITS,
    PER_CORE,
    RESTART_LIMIT,
    CpuStarvation,
    Kill,
    ParameterStorm,
    SolverBudget,
    Stop,
    sane,
)


@pytest.fixture
def flight():
    return Mock(observer=SimpleNamespace(heard={"b": 50.0}))


def test_a_killed_node_is_started_and_must_be_heard_again(flight, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    fault = Kill("b")
    fault.begin(flight, 0.5, 0)
    fault.end(flight)
    assert flight.supervisor.mock_calls == [call.kill("b"), call.restart("b")]
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
    frozen = [made(node) for node in NODES for made in (call.freeze, call.thaw)]
    assert flight.supervisor.mock_calls == frozen


def test_busy_processes_are_ended():
    fault = CpuStarvation()
    fault.begin(None, 1.0, 0)
    busy = fault._busy
    assert len(busy) == PER_CORE * os.cpu_count()
    assert all(process.poll() is None for process in busy)
    fault.end(None)
    assert all(process.poll() is not None for process in busy)


KNOWN = specifications(TrackingParameters)
CONFIGURED = {known.name: known.default for known in KNOWN}


def test_a_storm_asks_for_sane_and_absurd_values_and_puts_back(flight, monkeypatch):
    monkeypatch.setattr(nodes, "PERIOD", 0.0)
    client = flight.parameters
    client.known, client.configured = list(KNOWN), CONFIGURED
    fault = ParameterStorm()
    fault.begin(flight, 1.0, 3)
    for _ in range(200):
        fault.during(flight)
    names = {name for asked in client.ask.mock_calls for name in asked.args[0]}
    assert names >= {*CONFIGURED, "use_sim_time", "no_such_parameter"}
    fault.end(flight)
    client.put_back.assert_called_once_with()
    assert fault.settled(flight) is client.settled


def test_sane_values_do_not_widen_what_commands_are_held_to():
    rng = random.Random(0)
    for known in KNOWN:
        own = CONFIGURED[known.name]
        for _ in range(50):
            value = sane(known, own, rng)
            assert type(value) is type(own)
            if known.choices:
                assert value in known.choices
            elif isinstance(own, float):
                assert abs(value) <= abs(own) * (1.0 if known.name in LIMITS else 1.1)


def test_the_least_budget_is_asked_for_last_and_put_back(flight):
    fault = SolverBudget()
    fault.begin(flight, 1.0, 0)
    fault.end(flight)
    *asked, last = flight.parameters.mock_calls
    budgets = [each.args[0]["solve_time_max"] for each in asked]
    assert budgets == sorted(budgets, reverse=True)
    assert last == call.put_back()
