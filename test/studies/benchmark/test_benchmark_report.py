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

from uav_tracking_mpc.studies.benchmark.benchmark_report import benchmark_table, converged, save

ROW = {
    "transient_median_us": 10.0,
    "p99_us": 20.0,
    "max_us": 30.0,
    "alternating_median_us": 15.0,
    "alternating_p99_us": 40.0,
    "iterations_median": 2.0,
    "kkt_median": 2e-8,
    "kkt_p99": 3e-7,
    "closed_loop_cost": 50.0,
    "cold_median_us": None,
    "cold_solves": 0,
    "converged_share": None,
    "best_cost_share": None,
}


def results(share):
    other = {**ROW, "transient_median_us": 100.0, "alternating_median_us": 105.0}
    other = {**other, "kkt_median": 1e-3, "closed_loop_cost": 55.0}
    return {
        "cases": {"paper_n10": {"ours": {**ROW, "converged_share": share}, "ipopt": other}},
        "ratios": {"paper_n10": {"ipopt": 10.0}},
        "ratios_alternating": {"paper_n10": {"ipopt": 7.0}},
        "horizons": [5, 10],
        "horizon_median_us": {"ours": [5.0, 10.0], "ipopt": [50.0, 100.0]},
    }


def test_both_alternations_stand_beside_each_other():
    ours, other = benchmark_table(results(1.0)).rows
    assert ours[:2] == ["paper_n10", "ours"]
    assert other[:2] == ["", "ipopt"]
    assert [other[7], other[8], other[9]] == ["10.0", "105.0", "7.0"]


def test_how_optimal_the_plans_are_stands_beside_the_times():
    ours, other = benchmark_table(results(1.0)).rows
    assert [ours[5], ours[10]] == ["2e-08", "100.000"]
    assert [other[5], other[10]] == ["1e-03", "110.000"]


@pytest.mark.parametrize(("share", "enough"), [(1.0, True), (0.98, False), (None, True)])
def test_whether_ours_converged_decides(share, enough):
    assert converged(results(share)) is enough


def test_files(tmp_path):
    save(results(1.0), tmp_path / "new")
    assert json.loads((tmp_path / "new" / "benchmark.json").read_text()) == results(1.0)
    assert (tmp_path / "new" / "solve_time.png").read_bytes().startswith(b"\x89PNG")
