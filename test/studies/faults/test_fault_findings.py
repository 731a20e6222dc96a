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

import pytest

from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings, table
from uav_tracking_mpc.studies.faults.invariants import Violation
from uav_tracking_mpc.studies.faults.timeline import timeline


def case(index, *kinds, recovery=0.0, violations=()):
    findings = CaseFindings(index, kinds, begin=10.0 * index, end=10.0 * index + 3.0)
    findings.recovery = recovery
    for violation in violations:
        findings.add(violation)
    return findings


def campaign(*cases):
    return Campaign(
        config="paper",
        seed=3,
        minutes=1.0,
        speed=5.0,
        interrupted=False,
        cases=list(cases),
        families={"jitter": "network", "loss": "network", "odometry_nan": "odometry"},
        deaths=0,
        growth={"uav_simulator": 1.5, "nmpc_controller": None},
        range_errors=[(0.0, float("nan")), (1.0, 60.0), (2.0, 3.0)],
        storms={"asked": 4, "answered": 4, "accepted": 0},
    )


OLD = Violation("state age", "4 s older")
FLOWN = campaign(
    case(0, "loss", "jitter", recovery=4.0),
    case(1, "loss", recovery=12.5, violations=[OLD, OLD, Violation("geofence", "far")]),
)


def test_keys_of_the_json_object():
    summary = json.loads(json.dumps(FLOWN.summary()))
    assert summary["faults"] == 3
    assert summary["kinds"] == 2
    assert summary["violations"] == 2  # a hundred messages that break one rule in a case are one
    assert summary["deaths"] == 0
    assert summary["worst_recovery_s"] == 12.5
    assert summary["rss_growth_percent"] == 1.5
    assert (summary["seed"], summary["minutes"]) == (3, 1.0)
    assert summary["per_kind"]["loss"] == {"faults": 2, "violations": 2, "worst_recovery_s": 12.5}
    assert summary["per_kind"]["jitter"]["worst_recovery_s"] == 4.0
    assert summary["failing_cases"][0]["violations"]["state age"]["count"] == 2


@pytest.mark.parametrize(
    "cases", [(), (case(0, "loss", recovery=None), case(1, "jitter", recovery=1.0))]
)
def test_no_recovery_is_no_number(cases):
    assert campaign(*cases).summary()["worst_recovery_s"] is None


def test_people_are_told_what_failed():
    text = table(FLOWN.summary())
    assert "3 faults of 2 kinds in 2 cases: 2 violations, 0 deaths, worst recovery 12.5 s" in text
    assert "case 1 (loss): state age, 2 times: 4 s older" in text


def test_the_timeline_is_a_picture():
    assert timeline(FLOWN, 10.0, 30.0).startswith(b"\x89PNG")
    assert timeline(campaign(), 10.0, 30.0).startswith(b"\x89PNG")
