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


import json
from itertools import islice
from types import SimpleNamespace

import pytest
from rich.console import Console

from uav_tracking_mpc.report.figure_style import png
from uav_tracking_mpc.studies.faults.fault_campaign import (
    CaseFindings,
    FaultCampaign,
    Injection,
    in_words,
    summary,
    timeline,
)
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.kinds import Fault
from uav_tracking_mpc.studies.faults.schedule import schedule


class Flight(FaultCampaign):
    """A campaign whose clock is set by hand, five times as fast as real time."""

    tolerance, speed, clock = 10.0, 5.0, 100.0

    def now(self):
        return self.clock

    def watch(self, injections=()):
        raise KeyboardInterrupt


class Recorded(Fault):
    name = "recorded"
    family = "test"
    duration = (1.0, 1.0)
    settles = True

    def __init__(self):
        self.calls = []

    def begin(self, flight, seconds, seed):
        self.calls.append(("begin", seconds, seed))

    def during(self, flight):
        self.calls.append("during")

    def end(self, flight):
        self.calls.append("end")

    def settled(self, flight):
        return self.settles

    def violations(self, flight):
        return [ALWAYS]


ALWAYS = Violation("recorded", "always")


@pytest.fixture
def flight():
    return Flight(SimpleNamespace(name="test"), {"recorded": Recorded()}, Console(quiet=True))


def test_a_fault_begins_goes_on_ends_once_and_settles(flight, monkeypatch):
    fault = Recorded()
    injection = Injection(fault, 1.0, 7, flight)
    assert injection.step() == [ALWAYS]
    flight.clock += 0.2  # 1 s of simulated time
    monkeypatch.setattr(Recorded, "settles", False)
    injection.step()
    assert not injection.settled
    monkeypatch.setattr(Recorded, "settles", True)
    injection.step()
    injection.end()
    assert injection.settled
    assert fault.calls == [("begin", 0.2, 7), "during", "end"]


def test_a_duration_may_be_of_wall_time_and_an_interrupted_fault_is_ended(flight):
    fault = Recorded()
    fault.wall_time = True
    Injection(fault, 1.0, 7, flight).end()
    assert fault.calls == [("begin", 1.0, 7), "end"]


def test_before_the_first_case_an_interruption_ends_the_campaign_and_later_it_keeps_the_findings(
    flight,
):
    cases = list(islice(schedule({"recorded": Recorded()}, 0), 2))
    with pytest.raises(KeyboardInterrupt):
        flight.fly_cases(cases)
    flight.found.append(CaseFindings(0, ("recorded",), 0.0))
    assert flight.fly_cases(cases)
    assert flight.study(0, interrupted=True).content["cases"] == 1


def case(index, *kinds, recovery=0.0, violations=()):
    findings = CaseFindings(index, kinds, begin=10.0 * index, end=10.0 * index + 3.0)
    findings.recovery = recovery
    for violation in violations:
        findings.add(violation)
    return findings


FAMILIES = {"jitter": "network", "loss": "network", "odometry_nan": "odometry"}
OLD = Violation("state age", "4 s older")
FLOWN = (
    case(0, "loss", "jitter", recovery=4.0),
    case(1, "loss", recovery=12.5, violations=[OLD, OLD, Violation("geofence", "far")]),
)


def counted():
    return summary(FLOWN, FAMILIES, deaths=0, rss_growth_percent=1.5)


def test_keys_of_the_json_object():
    found = json.loads(json.dumps(counted()))
    told = {"faults": 3, "kinds": 2, "deaths": 0, "worst_recovery_s": 12.5}
    # A hundred messages that break one rule in a case are one violation.
    expected = {**told, "violations": 2, "rss_growth_percent": 1.5}
    assert {name: found[name] for name in expected} == expected
    row = {"faults": 2, "violations": 2, "loiters": 0, "worst_recovery_s": 12.5}
    assert found["per_kind"]["loss"] == row
    assert found["per_kind"]["jitter"]["worst_recovery_s"] == 4.0
    assert found["failing_cases"][0]["violations"]["state age"]["count"] == 2


@pytest.mark.parametrize(
    "cases", [(), (case(0, "loss", recovery=None), case(1, "jitter", recovery=1.0))]
)
def test_no_recovery_is_no_number(cases):
    assert summary(cases, FAMILIES)["worst_recovery_s"] is None


def test_people_are_told_what_failed():
    table, total, *failed = in_words(counted())
    assert [row[0] for row in table.rows] == ["jitter", "loss"]
    assert table.rows[1][1:] == ["2", "2", "0", "12.5 s"]
    assert total.startswith(
        "3 faults of 2 kinds in 2 cases: 2 violations, 0 deaths, worst recovery 12.5 s"
    )
    assert failed[0] == "case 1 (loss): state age, 2 times: 4 s older"


@pytest.mark.parametrize("cases", [FLOWN, ()])
def test_the_timeline_is_a_picture(cases):
    errors = [(0.0, float("nan")), (1.0, 60.0), (2.0, 3.0)]
    assert png(timeline("paper, seed 3", cases, FAMILIES, errors, 10.0)).startswith(b"\x89PNG")


def test_a_loiter_of_the_autopilot_is_no_loss():
    kept = case(1, "loss", recovery=None)
    kept.loiters = True
    cases = [case(0, "loss", recovery=1.5), kept]
    found = summary(cases, FAMILIES)
    assert found["outcomes"] == {"orbit": 1, "loiter": 1, "lost": 0}
    assert found["worst_recovery_s"] == 1.5
    assert found["per_kind"]["loss"]["loiters"] == 1
    assert "1 times loiter" in in_words(found)[1]
    lost = summary([*cases, case(2, "jitter", recovery=None)], FAMILIES)
    assert lost["worst_recovery_s"] is None
