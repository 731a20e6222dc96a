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

from uav_tracking_mpc.studies.faults.fault_campaign import Injection
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.kinds import Fault

pytest.importorskip("rclpy")


FLIGHT = SimpleNamespace(speed=5.0, now=lambda: time.monotonic())


class Recorded(Fault):
    name = "recorded"
    family = "test"
    duration = (1.0, 1.0)

    def __init__(self):
        self.calls, self.settles = [], True

    def begin(self, flight, seconds, seed):
        self.calls.append(("begin", seconds, seed))

    def during(self, flight):
        self.calls.append("during")

    def end(self, flight):
        self.calls.append("end")

    def settled(self, flight):
        return self.settles

    def violations(self, flight):
        return [Violation("recorded", "always")]


@pytest.fixture
def now(monkeypatch):
    clock = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: clock[0])
    return clock


def test_a_fault_begins_goes_on_ends_once_and_settles(now):
    fault = Recorded()
    injection = Injection(fault, 1.0, 7, FLIGHT)
    assert fault.calls == [("begin", 0.2, 7)]  # 1 s of simulated time at five times real time
    assert injection.step() == [Violation("recorded", "always")]
    assert fault.calls[1:] == ["during"]
    now[0] += 0.2
    fault.settles = injection._fault.settles = False
    injection.step()
    assert not injection.settled
    injection._fault.settles = True
    injection.step()
    injection.end()
    assert injection.settled
    assert fault.calls[2:] == ["end"]


def test_a_duration_may_be_of_wall_time(now):
    fault = Recorded()
    fault.wall_time = True
    Injection(fault, 1.0, 7, FLIGHT)
    assert fault.calls == [("begin", 1.0, 7)]


def test_an_interrupted_fault_is_ended(now):
    fault = Recorded()
    injection = Injection(fault, 1.0, 7, FLIGHT)
    injection.end()
    assert fault.calls[1:] == ["end"]
