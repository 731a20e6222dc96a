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

from solver_problems import paper_solver

from uav_tracking_mpc.mpc.casadi_solver import CasadiSolver
from uav_tracking_mpc.studies.benchmark.cases import paper_case
from uav_tracking_mpc.studies.benchmark.solver_timing import OURS, TRANSIENT_STEPS, measure, summary


def test_summary_has_the_figures_of_every_solver():
    case = paper_case(10)
    solvers = {OURS: paper_solver(), "fatrop": CasadiSolver(case.problem, "fatrop")}
    records = measure(case, solvers, repetitions=2, cold=4, peers_cold=2, seed=0)
    for record in records.values():
        assert len(record.warm) == len(record.alternating) == 2 * (TRANSIENT_STEPS - 1)
    figures = summary(records)
    assert figures[OURS]["cold_solves"] == 4
    assert figures["fatrop"]["cold_solves"] == 2
    assert figures[OURS]["converged_share"] == figures[OURS]["warm_converged_share"] == 1.0
    assert figures[OURS]["best_cost_states"] == 2
    for row in figures.values():
        assert row["p99_us"] >= row["transient_median_us"] > 0.0
        assert row["alternating_p99_us"] >= row["alternating_median_us"] > 0.0


def test_without_cold_starts_there_are_no_shares():
    case = paper_case(10)
    records = measure(case, {OURS: paper_solver()}, repetitions=1, cold=0, peers_cold=0, seed=0)
    row = summary(records)[OURS]
    assert row["converged_share"] is row["best_cost_share"] is row["cold_median_us"] is None
