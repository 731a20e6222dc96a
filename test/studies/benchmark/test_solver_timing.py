from __future__ import annotations

import numpy as np
import pytest
from solver_problems import paper_solver

from uav_tracking_mpc.studies.benchmark.cases import cases, paper_case
from uav_tracking_mpc.studies.benchmark.solver_timing import OURS, measure, peers, summary

NAMES = ["paper_n10", "paper_n10_ellipsoid", "paper_n30", "paper_n30_ellipsoid", "flight_n20"]


def test_cases_have_the_names_that_readers_of_the_json_expect():
    assert [case.name for case in cases()] == NAMES


@pytest.mark.parametrize("case", cases(), ids=NAMES)
def test_random_states_are_repeatable_and_inside_the_model(case):
    states = case.cold_states(20, seed=4)
    np.testing.assert_array_equal(states, case.cold_states(20, seed=4))
    plant = case.plant()
    rest = np.clip(np.zeros(3), case.problem.input_lower, case.problem.input_upper)
    assert all(np.all(np.isfinite(plant(state, rest))) for state in states)


def test_summary_has_the_figures_of_every_solver():
    case = paper_case(10)
    solvers = {OURS: paper_solver(), **peers(case, ("fatrop",))}
    records = measure(case, solvers, repetitions=2, cold=4, peers_cold=2, seed=0)
    figures = summary(records)
    assert figures[OURS]["cold_solves"] == 4
    assert figures["fatrop"]["cold_solves"] == 2
    assert figures[OURS]["converged_share"] == 1.0
    assert figures[OURS]["best_cost_states"] == 2
    assert figures[OURS]["transient_median_us"] < figures["fatrop"]["transient_median_us"] / 10
    assert figures[OURS]["p99_us"] >= figures[OURS]["transient_median_us"]
