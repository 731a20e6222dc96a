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

"""The report on the paper: verdicts found by the program; its pages are current."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from uav_tracking_mpc.studies.stability.paper_report import (
    as_markdown,
    distance_budget,
    numbers_table,
    paper_as_printed,
    paper_report,
    verdicts,
)
from uav_tracking_mpc.terminal.ingredients import PAPER_INITIAL_STATE, paper_problem

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def last_digit(number: str) -> float:
    """What one step of the last digit of a printed number is worth."""
    mantissa, _, exponent = number.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def assert_same(found: str, expected: str) -> None:
    """Fail where words differ, or a decimal number by more than one step of its last digit.

    The last digit that a table prints depends on how a library of linear algebra rounds.
    """
    assert NUMBER.split(found) == NUMBER.split(expected)
    for one, other in zip(NUMBER.findall(found), NUMBER.findall(expected), strict=True):
        step = max(last_digit(one), last_digit(other)) if "." in one + other else 0.0
        assert abs(float(one) - float(other)) <= 1.001 * step, f"{one} is not {other}"


TEXT = "| varrho | 3.1733 | -1.2e-05 | row 12 | L2 |"


def test_the_last_digit_may_move_and_nothing_else_may():
    for old, new in (("3.1733", "3.1734"), ("-1.2e-05", "-1.1e-05")):
        assert_same(TEXT.replace(old, new), TEXT)
    other = (("3.1733", "3.1735"), ("-1.2e-05", "1.2e-05"), ("12", "13"), ("L2", "L3"))
    for old, new in (*other, ("row", "line")):
        with pytest.raises(AssertionError):
            assert_same(TEXT.replace(old, new), TEXT)


@pytest.fixture(scope="module")
def rows():
    return {row["name"]: row for row in paper_report()}


def test_the_printed_certificate_does_not_hold(rows):
    assert not paper_as_printed()["holds"]
    factor = rows["right over left of (41), holds if at most 1"]["printed_A"]
    assert factor == pytest.approx(1.1111 / 0.22859, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "verdict"),
    [
        ("right over left of (41), holds if at most 1", "does not hold"),
        ("b = 2 L |A_K|_P + L^2, L as printed", "cross term"),
        ("L at varrho = 3.1733", "(11)"),
        ("A[1,0]", "(12) evaluates to 4"),
        ("A[0,3]", "1.333"),
    ],
)
def test_verdicts_name_what_is_wrong(rows, name, verdict):
    assert verdict in rows[name]["verdict"]


@pytest.mark.parametrize(
    ("name", "column", "value", "tolerance"),
    [
        ("L at varrho = 3.1733", "model_11", 0.5178, 2e-4),
        ("L at varrho = 3.2649", "model_11", 0.5247, 2e-4),
        ("varrho where (41) stops holding", "model_11", 0.230, 2e-3),
        ("varrho where (41) stops holding", "exact", 1.59, 1e-2),
    ],
)
def test_numbers_are_recomputed(rows, name, column, value, tolerance):
    assert rows[name][column] == pytest.approx(value, abs=tolerance)


def test_initial_state_is_infeasible_at_ten_steps():
    needed, possible = distance_budget(paper_problem(), PAPER_INITIAL_STATE, 3.1733)
    assert possible < needed
    assert possible == pytest.approx(41.0, abs=0.5)


DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_every_row_has_a_verdict():
    rows = paper_report()
    assert all(row["verdict"] for row in rows)
    assert [row[0] for row in numbers_table(rows).rows] == [str(n + 1) for n in range(len(rows))]
    lines = verdicts(rows)
    assert [int(line.split()[0]) for line in lines] == list(range(1, len(rows) + 1))
    assert any("the printed certificate does not hold" in line for line in lines)


def test_the_page_is_current():
    assert_same((DOCS / "paper_errata.md").read_text(), as_markdown(paper_report()))


def test_pictures_of_the_page_exist_and_are_small():
    names = re.findall(r"!\[.*?\]\((.*?)\)", (DOCS / "stability.md").read_text())
    assert len(names) >= 3
    for name in names:
        assert 0 < (DOCS / name).stat().st_size < 300_000
