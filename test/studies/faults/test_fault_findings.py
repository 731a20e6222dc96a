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

from uav_tracking_mpc.studies.faults.fault_findings import Campaign, CaseFindings, table, timeline
from uav_tracking_mpc.studies.faults.invariants import Violation


def case(index, *kinds, recovery=0.0, violations=()):
    findings = CaseFindings(index, kinds, begin=10.0 * index, end=10.0 * index + 3.0)
    findings.recovery = recovery
    for violation in violations:
        findings.add(violation)
    return findings


def campaign(*cases, **more):
    return Campaign(
        config="paper",
        seed=3,
        cases=list(cases),
        families={"jitter": "network", "loss": "network", "odometry_nan": "odometry"},
        range_errors=[(0.0, float("nan")), (1.0, 60.0), (2.0, 3.0)],
        tolerance=10.0,
        limit=30.0,
        more=more,
    )


OLD = Violation("state age", "4 s older")
FLOWN = campaign(
    case(0, "loss", "jitter", recovery=4.0),
    case(1, "loss", recovery=12.5, violations=[OLD, OLD, Violation("geofence", "far")]),
    deaths=0,
    rss_growth_percent=1.5,
)


def test_keys_of_the_json_object():
    summary = json.loads(json.dumps(FLOWN.summary()))
    assert summary["faults"] == 3
    assert summary["kinds"] == 2
    assert summary["violations"] == 2  # a hundred messages that break one rule in a case are one
    assert summary["deaths"] == 0
    assert summary["worst_recovery_s"] == 12.5
    assert summary["rss_growth_percent"] == 1.5
    assert summary["seed"] == 3
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
    assert timeline(FLOWN).startswith(b"\x89PNG")
    assert timeline(campaign()).startswith(b"\x89PNG")


def test_a_loiter_of_the_autopilot_is_no_loss():
    kept = case(1, "loss", recovery=None)
    kept.loiters = True
    outcomes = {"orbit": 1, "loiter": 1, "lost": 1}
    flown = campaign(case(0, "loss", recovery=1.5), kept, outcomes=outcomes)
    summary = flown.summary()
    assert summary["worst_recovery_s"] == 1.5
    assert summary["per_kind"]["loss"]["loiters"] == 1
    assert "1 times loiter" in table(summary)
    lost = campaign(*flown.cases, case(2, "jitter", recovery=None), outcomes=outcomes).summary()
    assert lost["worst_recovery_s"] is None
