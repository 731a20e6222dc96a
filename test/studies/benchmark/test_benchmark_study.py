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

"""The problems of the benchmark are those that are flown."""

import contextlib
import json
from types import SimpleNamespace

import numpy as np
import pytest
from solver_problems import paper_solver

from uav_tracking_mpc.formulation.flight_formulation import FlightFormulation
from uav_tracking_mpc.mpc.newton_solver import NewtonSolver
from uav_tracking_mpc.mpc.solver import Status
from uav_tracking_mpc.settings.configuration import load_configuration
from uav_tracking_mpc.studies.benchmark import benchmark_study as module
from uav_tracking_mpc.studies.benchmark.benchmark_study import (
    OURS,
    TRANSIENT_STEPS,
    FatropSolver,
    benchmark_table,
    cases,
    flight_case,
    measure,
    paper_case,
    summary,
)

NAMES = ["paper_n10", "paper_n10_ellipsoid", "paper_n30", "paper_n30_ellipsoid", "flight_n20"]


@pytest.fixture(scope="module")
def all_cases():
    return {case.name: case for case in cases()}


@pytest.mark.parametrize("name", NAMES)
def test_random_starts_are_repeatable_and_fit_the_problem(name, all_cases):
    assert list(all_cases) == NAMES  # readers of the JSON expect them
    case = all_cases[name]
    starts, again = case.cold_starts(20, 4), case.cold_starts(20, 4)
    for one, other in zip(starts, again, strict=True):
        np.testing.assert_array_equal(one.state, other.state)
        assert one.state.shape == (case.problem.nx,)
        assert np.all(np.isfinite(one.state))
    assert len({tuple(start.state) for start in starts}) == 20
    if name == "flight_n20":
        assert len({start.parameters.tobytes() for start in starts}) > 10  # drifts of their own


def test_the_flight_case_is_the_problem_of_small_uav():
    """Same expressions as in flight, but for the horizon: a flight of N = 22 tells them apart."""
    flown = FlightFormulation(load_configuration("small_uav").controller).solver.problem
    timed = flight_case(flown.horizon).problem
    for part in ("stage_cost", "next_state", "terminal_cost", "terminal_equality"):
        assert str(getattr(timed, part)) == str(getattr(flown, part))
    np.testing.assert_array_equal(timed.input_lower, flown.input_lower)
    assert flight_case().problem.horizon == 20


def test_summary_has_the_figures_of_every_solver():
    case = paper_case(10)
    solvers = {OURS: paper_solver(), "fatrop": FatropSolver(case.problem)}
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


def test_a_state_that_nobody_solved_is_nobodys_best(monkeypatch):
    case = paper_case(10)
    records = measure(case, {OURS: paper_solver()}, repetitions=1, cold=2, peers_cold=2, seed=0)
    (plan, duration), other = records[OURS].cold
    records[OURS].cold[:] = [(plan._replace(status=Status.ITERATION_LIMIT), duration), other]
    assert summary(records)[OURS]["best_cost_share"] == 0.5


def test_further_solvers_are_timed_and_those_that_are_lost_are_left_out(monkeypatch):
    case = paper_case(10)

    @contextlib.contextmanager
    def peers(problem, say):
        found = {"kept": NewtonSolver(problem), "lost": NewtonSolver(problem)}
        yield found
        say("lost is left out")
        del found["lost"]

    monkeypatch.setattr(module, "cases", lambda: [case])
    monkeypatch.setattr(module, "all_solvers", lambda case: {OURS: NewtonSolver(case.problem)})
    found = module.benchmark(cold=1, quick=True, peers=peers)
    assert list(found["cases"]["paper_n10"]) == [OURS, "kept"]
    assert list(found["ratios"]["paper_n10"]) == ["kept"]


def test_without_cold_starts_there_are_no_shares():
    records = measure(
        paper_case(10), {OURS: paper_solver()}, repetitions=1, cold=0, peers_cold=0, seed=0
    )
    row = summary(records)[OURS]
    assert row["converged_share"] is row["best_cost_share"] is row["cold_median_us"] is None


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
    other |= {"kkt_median": 1e-3, "closed_loop_cost": 55.0}
    return {
        "cases": {"paper_n10": {"ours": {**ROW, "converged_share": share}, "ipopt": other}},
        "ratios": {"paper_n10": {"ipopt": 10.0}},
        "ratios_alternating": {"paper_n10": {"ipopt": 7.0}},
        "horizons": [5, 10],
        "horizon_median_us": {"ours": [5.0, 10.0], "ipopt": [50.0, 100.0]},
        "mission_steps": 1,
        "missions_per_second": 1.0,
        "duration_s": 1.0,
    }


def test_alternations_and_optimality_stand_beside_each_other():
    ours, other = benchmark_table(results(1.0)).rows
    assert ours[:2] == ["paper_n10", "ours"]
    assert other[:2] == ["", "ipopt"]
    assert other[7:10] == ["10.0", "105.0", "7.0"]
    assert [ours[5], ours[10]] == ["2e-08", "100.000"]
    assert [other[5], other[10]] == ["1e-03", "110.000"]


@pytest.mark.parametrize(("share", "enough"), [(1.0, True), (0.98, False), (None, True)])
def test_whether_ours_converged_decides_and_files_hold_what_was_found(share, enough, tmp_path):
    study = module.benchmark_study(found := results(share))
    assert study.good is enough
    if share == 1.0:
        study.publish(tmp_path / "new")
        assert json.loads((tmp_path / "new" / "benchmark.json").read_text()) == found
        assert (tmp_path / "new" / "solve_time.png").read_bytes().startswith(b"\x89PNG")


def test_missions_after_the_first_are_timed(monkeypatch):
    """By a clock that missions alone move: the first takes 100 s, each other one 0.25 s."""
    flown = []
    elapsed = lambda: 100.0 * (len(flown) > 0) + 0.25 * max(len(flown) - 1, 0)  # noqa: E731
    monkeypatch.setattr(module, "time", SimpleNamespace(perf_counter=elapsed))

    def mission(_, state, parameters):
        flown.append((state, parameters))
        while True:
            steps.append(len(flown))
            yield

    monkeypatch.setattr(module, "solutions", mission)
    case, steps = paper_case(10), []
    assert module.missions_per_second(case, 7, count=12) == pytest.approx(4.0)
    assert steps == np.repeat(np.arange(1, 14), 7).tolist()
    for state, parameters in flown:
        assert (state, parameters) == (case.start.state, case.start.parameters)
