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

"""Certified, sampled or neither; a changed parameter voids a certificate."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("flint")

from uav_tracking_mpc.terminal.certificate import certificate, read_certificate
from uav_tracking_mpc.terminal.direct_condition import prove_direct_condition
from uav_tracking_mpc.terminal.stability_problem import paper_problem
from uav_tracking_mpc.terminal.status import certificate_status

PROBLEM = paper_problem()
PARTS = PROBLEM.ingredients()


@pytest.fixture(scope="module")
def written():
    return certificate(PROBLEM, PARTS, prove_direct_condition(PROBLEM, PARTS, 2.5))


def status(problem, parts, level, content):
    return certificate_status(problem, parts, level, content, samples=2000)


def test_certified_at_and_below_the_proved_level(written):
    for level in (2.5, 1.0):
        assert status(PROBLEM, PARTS, level, written).status == "certified"


def test_another_horizon_is_still_certified(written):
    assert status(replace(PROBLEM, horizon=20), PARTS, 2.5, written).status == "certified"


def test_larger_level_is_only_sampled(written):
    answer = status(PROBLEM, PARTS, 2.6, written)
    assert answer.status == "sampled"
    assert "level" in answer.reason


@pytest.mark.parametrize(
    "changes",
    [
        {"step": 0.9},
        {"scaling": 2.4},
        {"model": "paper"},
        {"scheme": "rk4"},
        {"orbit": replace(PROBLEM.orbit, speed=4.1)},
        {"state_weight": 1.1 * PROBLEM.state_weight},
        {"input_weight": 1.1 * PROBLEM.input_weight},
        {"input_upper": 1.1 * PROBLEM.input_upper},
    ],
)
def test_any_changed_parameter_voids_it(written, changes):
    problem = replace(PROBLEM, **changes)
    answer = status(problem, problem.ingredients(), 2.4, written)
    assert answer.status != "certified"
    assert "void" in answer.reason


def test_changed_gain_voids_it(written):
    parts = replace(PARTS, gain=PARTS.gain * (1.0 + 1e-6))
    assert status(PROBLEM, parts, 2.4, written).status == "sampled"


def test_neither_where_a_sample_breaks_the_decrease():
    wide = replace(PROBLEM, input_lower=np.full(3, -99.0), input_upper=np.full(3, 99.0))
    assert status(wide, PARTS, 18.5, None).status == "neither"


def test_neither_beyond_the_inputs_and_without_a_set():
    assert status(PROBLEM, PARTS, 4.0, None).status == "neither"
    assert status(PROBLEM, PARTS, None, None).status == "neither"


def test_a_failed_proof_writes_no_certificate():
    with pytest.raises(ValueError, match="not proved"):
        certificate(PROBLEM, PARTS, prove_direct_condition(PROBLEM, PARTS, 3.5))


def test_file_round_trip(written, tmp_path):
    (tmp_path / "c.json").write_text(json.dumps(written))
    assert read_certificate(tmp_path / "c.json") == written
    (tmp_path / "list.json").write_text("[]")
    with pytest.raises(ValueError, match="no certificate"):
        read_certificate(tmp_path / "list.json")


def test_shipped_certificate_covers_the_papers_configuration():
    path = Path(__file__).resolve().parents[2] / "config" / "certificates" / "paper.json"
    content = read_certificate(path)
    answer = certificate_status(PROBLEM, PARTS, content["level"], content)
    assert answer.status == "certified"
    assert content["level"] > 2.85
