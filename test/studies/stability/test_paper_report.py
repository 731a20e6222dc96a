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

"""The report on the paper: verdicts found by the program."""

import pytest

from uav_tracking_mpc.studies.stability.distance_budget import distance_budget
from uav_tracking_mpc.studies.stability.paper_report import paper_as_printed, paper_report
from uav_tracking_mpc.terminal.stability_problem import PAPER_INITIAL_STATE, paper_problem


@pytest.fixture(scope="module")
def rows():
    return {row.name: row for row in paper_report()}


def test_printed_certificate_does_not_hold(rows):
    assert not paper_as_printed()["holds"]
    row = rows["right over left of (41), holds if at most 1"]
    assert row.printed_A == pytest.approx(1.1111 / 0.22859, rel=1e-3)
    assert "does not hold" in row.verdict


def test_missing_cross_term_is_found(rows):
    assert "cross term" in rows["b = 2 L |A_K|_P + L^2, L as printed"].verdict


def test_lipschitz_constant_reproduces_with_11(rows):
    assert rows["L at varrho = 3.1733"].model_11 == pytest.approx(0.5178, abs=2e-4)
    assert rows["L at varrho = 3.2649"].model_11 == pytest.approx(0.5247, abs=2e-4)
    assert "(11)" in rows["L at varrho = 3.1733"].verdict


def test_levels_where_41_stops(rows):
    row = rows["varrho where (41) stops holding"]
    assert row.model_11 == pytest.approx(0.230, abs=2e-3)
    assert row.exact == pytest.approx(1.59, abs=1e-2)


def test_matrices_disagree(rows):
    assert "(12) evaluates to 4" in rows["A[1,0]"].verdict
    assert "1.333" in rows["A[0,3]"].verdict


def test_initial_state_is_infeasible_at_ten_steps():
    needed, possible = distance_budget(paper_problem(), PAPER_INITIAL_STATE, 3.1733)
    assert possible < needed
    assert possible == pytest.approx(41.0, abs=0.5)


def test_every_row_has_a_verdict(rows):
    assert all(row.verdict for row in rows.values())
